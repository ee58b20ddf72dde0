//! The GLB, read by Gonio's own reader and by its JSON.

use crate::fixture::{exported, files, full, mesh, plain};
use gonio_export::{Export, Format};
use serde_json::Value;
use std::sync::Arc;

fn document(export: &Export) -> Value {
    let glb = &export.files["scene.glb"];
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&glb[..4], word(4), word(8)), (&b"glTF"[..], 2, glb.len()));
    assert_eq!(&glb[16..20], b"JSON");
    serde_json::from_slice(&glb[20..20 + word(12)]).unwrap()
}

#[test]
fn the_mesh_reads_back_where_it_was() {
    let export = exported(&plain(), Format::Gltf);
    let mut files = files();
    files.0.insert("scene.glb".into(), Arc::from(export.files["scene.glb"].as_slice()));
    let found = gonio_scene::mesh::read(&files, "scene.glb").unwrap();
    let mesh = mesh();
    assert_eq!(found.triangles, mesh.triangles);
    for (found, p) in found.positions.iter().zip(&mesh.positions) {
        // The object's motion, then y up: (x, y, z) to (x, z, -y).
        let world = [0.1 - p[1], 0.2 + p[0], 0.3 + p[2]];
        let upright = [world[0], world[2], -world[1]];
        assert!(found.iter().zip(upright).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {upright:?}");
    }
}

#[test]
fn every_photo_is_a_scene_with_its_lamps() {
    let root = document(&exported(&plain(), Format::Gltf));
    let children = |photo: usize| {
        let node = root["scenes"][photo]["nodes"][0].as_u64().unwrap() as usize;
        root["nodes"][node]["children"].as_array().unwrap().len()
    };
    assert_eq!((children(0), children(1)), (3, 4));
    assert_eq!(root["scenes"][1]["name"], "01");
    let lights = root["extensions"]["KHR_lights_punctual"]["lights"].as_array().unwrap();
    assert_eq!(lights[0]["intensity"], 0.4);
    assert_eq!(lights[0]["color"], serde_json::json!([1.0, 0.5, 0.25]));
    let lens = &root["cameras"][0]["perspective"];
    assert!((libm::tan(lens["yfov"].as_f64().unwrap() / 2.0) - 0.25).abs() < 1e-12);
    assert!((lens["aspectRatio"].as_f64().unwrap() - 4.0 / 3.0).abs() < 1e-12);
    let shell = &root["materials"][0];
    assert_eq!(shell["extensions"]["KHR_materials_ior"]["ior"], 1.5);
    assert_eq!(shell["pbrMetallicRoughness"]["roughnessFactor"], 0.4);
}

#[test]
fn extensions_that_are_used_are_named() {
    let root = document(&exported(&full(), Format::Gltf));
    let used: Vec<&str> =
        root["extensionsUsed"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    let expected = ["anisotropy", "clearcoat", "ior", "sheen", "specular"].map(|name| format!("KHR_materials_{name}"));
    assert_eq!(used, [&["KHR_lights_punctual"][..], &expected.each_ref().map(String::as_str)].concat());
    let tangent = &root["meshes"][0]["primitives"][0]["attributes"]["TANGENT"];
    assert_eq!(root["accessors"][tangent.as_u64().unwrap() as usize]["type"], "VEC4");
    for view in root["bufferViews"].as_array().unwrap() {
        let end = view["byteOffset"].as_u64().unwrap() + view["byteLength"].as_u64().unwrap();
        assert!(end <= root["buffers"][0]["byteLength"].as_u64().unwrap());
    }
}
