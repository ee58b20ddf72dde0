//! glTF 2.0: one GLB with a scene for every photo.
//!
//! Each scene has one node that turns z up into glTF's y up; below it the objects, the photo's camera and its lamps. Meshes and
//! materials are shared. glTF has no environment maps: they lie beside it.

mod buffer;
mod light;
mod material;
mod texture;

use crate::Result;
use crate::files::FileMap;
use crate::ledger::Ledger;
use crate::matrix::{Matrix, columns, diagonal, product};
use crate::scene::Scene;
use crate::sky;
use crate::surface::Effect;
use crate::view::{View, for_each_camera};
use buffer::Buffer;
use gonio_scene::capture::{Camera, LightKind, MapRole};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use texture::Textures;

const FILE: &str = "scene.glb";

/// z up to y up.
const UPRIGHT: Matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// The GLB, and the maps.
///
/// # Errors
/// A map that cannot be encoded.
pub fn files(scene: &Scene<'_>, ledger: &mut Ledger) -> Result<FileMap> {
    judge(scene, ledger);
    let mut used = BTreeSet::new();
    let mut buffer = Buffer::default();
    let mut textures = Textures::default();
    let mut materials = Vec::new();
    for surface in &scene.surfaces {
        let mut material = material::of(surface, &mut used);
        textures.vary(surface, &mut material, &mut buffer)?;
        materials.push(material);
    }
    let meshes: Vec<Value> = scene
        .placed()
        .map(|(part, index)| {
            let surface = &scene.surfaces[index];
            let turn = surface.material.effects.anisotropy_rotation;
            let tangents = surface.has(Effect::Anisotropy).then_some(turn);
            let colours = texture::values(surface, MapRole::BaseColor);
            let primitive = buffer.mesh(part, colours.as_ref(), tangents, index);
            json!({ "name": part.stem, "primitives": [primitive] })
        })
        .collect();
    let mut nodes = Vec::new();
    let mut lights = Vec::new();
    let scenes: Vec<Value> = scene
        .views
        .iter()
        .enumerate()
        .map(|(number, view)| {
            let mut children = Vec::new();
            for (mesh, part) in scene.parts.iter().enumerate() {
                let matrix = columns(&part.to_world);
                children.push(push(&mut nodes, json!({ "name": part.stem, "mesh": mesh, "matrix": matrix })));
            }
            let to_world = columns(&product(&view.pose, &diagonal([1.0, -1.0, -1.0])));
            let name = format!("camera {}", view.stem);
            children.push(push(&mut nodes, json!({ "name": name, "camera": number, "matrix": to_world })));
            for lamp in &view.lamps {
                let (light, to_world) = light::of(lamp, &scene.capture.lights[lamp.light].name);
                let light = push(&mut lights, light);
                let extension = json!({ "KHR_lights_punctual": { "light": light } });
                let node = json!({ "extensions": extension, "matrix": columns(&to_world) });
                children.push(push(&mut nodes, node));
            }
            let root =
                json!({ "name": format!("world {}", view.stem), "children": children, "matrix": columns(&UPRIGHT) });
            json!({ "name": view.stem, "nodes": [push(&mut nodes, root)] })
        })
        .collect();
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "gonio export" },
        "scene": 0, "scenes": scenes, "nodes": nodes, "meshes": meshes, "materials": materials,
        "cameras": scene.views.iter().map(camera).collect::<Vec<_>>(),
    });
    if !lights.is_empty() {
        used.insert("KHR_lights_punctual");
        root["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    }
    if !used.is_empty() {
        root["extensionsUsed"] = json!(used);
    }
    textures.finish(&mut root);
    let mut files = sky::files(scene)?;
    files.insert(FILE.to_owned(), buffer.glb(root));
    Ok(files)
}

/// Adds to a list; its index there.
fn push(list: &mut Vec<Value>, value: Value) -> usize {
    list.push(value);
    list.len() - 1
}

/// A camera that looks along -z with y up, its axis through the image's centre.
fn camera(view: &View) -> Value {
    let camera = &view.camera;
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    json!({
        "name": view.stem, "type": "perspective",
        "perspective": {
            "aspectRatio": width / camera.fx * camera.fy / height, "yfov": 2.0 * libm::atan(height / 2.0 / camera.fy),
            "znear": 0.001, "zfar": 10000.0,
        },
        "extras": { "width": camera.width, "height": camera.height },
    })
}

fn judge(scene: &Scene<'_>, ledger: &mut Ledger) {
    for surface in &scene.surfaces {
        material::judge(surface, ledger);
    }
    for_each_camera(scene.capture, |name, camera| {
        ledger.exact(name, "yfov and aspectRatio");
        let [x, y] = off_centre(camera);
        for (key, off) in [("cx", x), ("cy", y)] {
            if off > 1e-6 {
                let why = format!(
                    "glTF's cameras have their axis in the image's centre: the picture is shifted by {off} pixels"
                );
                ledger.lost(&format!("{name}.{key}"), &why);
            }
        }
        for key in ["aperture_radius", "focus_distance"] {
            if camera.aperture_radius > 0.0 {
                ledger.lost(&format!("{name}.{key}"), "glTF's cameras are pinholes");
            } else {
                ledger.exact(&format!("{name}.{key}"), "a pinhole");
            }
        }
        if camera.distortion != [0.0; 5] {
            ledger.lost(&format!("{name}.distortion"), "glTF's cameras do not distort");
        }
    });
    for light in &scene.capture.lights {
        let name = format!("light.{}", light.name);
        match light.kind {
            LightKind::Point { .. } => ledger.exact(&name, "a punctual light; a unit of radiance counts as 1 cd/m^2"),
            LightKind::Sphere { .. } => {
                ledger.exact(&name, "a punctual light; a unit of radiance counts as 1 cd/m^2");
                ledger.lost(&format!("{name}.radius"), "glTF's lamps are points");
            }
            LightKind::Directional { .. } => {
                ledger.exact(&name, "a punctual light; a unit of irradiance counts as 1 lux");
            }
            LightKind::Map { .. } => ledger.lost(&name, "glTF has no environment map; its file lies in maps/"),
            LightKind::Constant { .. } => ledger.lost(&name, "glTF has no light from everywhere"),
        }
        ledger.lose_lobe(light, "glTF has no lamp of this lobe: it shines to all sides as brightly as along its axis");
    }
}

/// How far the principal point lies from the centre, pixels.
fn off_centre(camera: &Camera) -> [f64; 2] {
    [camera.cx - f64::from(camera.width) / 2.0, camera.cy - f64::from(camera.height) / 2.0].map(f64::abs)
}
