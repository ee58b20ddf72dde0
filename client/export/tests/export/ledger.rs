//! What became of every number.

use crate::fixture::{exported, full, json, plain};
use gonio_export::{Format, RECORD_FILE};
use gonio_scene::Capture;
use std::collections::BTreeSet;

/// The keys of an export that were kept as `word` says, without places in lists and numbers of photos.
fn kept(text: &str, format: Format, word: &str) -> BTreeSet<String> {
    let entries = exported(text, format).record.numbers;
    let of = entries.iter().filter(|entry| entry.kept.word() == word).map(|entry| {
        let parts: Vec<&str> = entry.name.split('.').collect();
        let listed =
            ["distortion", "albedo_variation", "roughness_variation", "bump", "radiance", "lobe_axis", "sheen_color"];
        let listed = [&listed[..], &["base_color", "eta", "k"]].concat();
        let end = parts.iter().position(|part| listed.contains(part)).map_or(parts.len(), |at| at + 1);
        parts[..end].join(".")
    });
    of.filter(|name| !name.starts_with("photo.")).collect()
}

fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// Lost in every format.
const ALWAYS: [&str; 5] = [
    "camera.distortion",
    "material.shell.albedo_variation",
    "material.shell.bump",
    "material.shell.roughness_variation",
    "sensor.saturation",
];

fn lost(more: &[&str]) -> BTreeSet<String> {
    set(&[&ALWAYS[..], more].concat())
}

const LOBE: [&str; 2] = ["light.led.lobe_axis", "light.led.lobe_exponent"];

#[test]
fn every_number_is_judged_and_has_a_reason() {
    for (text, format) in Format::ALL.into_iter().flat_map(|f| [(plain(), f), (full(), f)]) {
        let export = exported(&text, format);
        let capture = Capture::parse(&text).unwrap();
        let names: BTreeSet<&str> = export.record.numbers.iter().map(|entry| entry.name.as_str()).collect();
        assert!(capture.numbers().keys().all(|name| names.contains(name.as_str())), "{format}");
        for entry in &export.record.numbers {
            let how = entry.kept.how();
            assert!(!how.is_empty() && !how.contains("does not know"), "{format}: {entry:?}");
        }
        let file = json(&export, RECORD_FILE);
        assert_eq!(file["format"], format.word());
        assert_eq!(file["numbers"].as_array().unwrap().len(), names.len());
        assert_eq!(file["photos"][1]["name"], "01");
        let listed: BTreeSet<&str> = file["files"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
        assert!(export.files.keys().all(|name| name == RECORD_FILE || listed.contains(name.as_str())));
        assert!(export.files.keys().all(|name| !name.contains("..") && !name.starts_with('/')), "{format}");
    }
}

#[test]
fn a_plain_capture_loses_nothing_in_mitsuba() {
    assert_eq!(kept(&plain(), Format::Mitsuba, "lost"), set(&[]));
    assert_eq!(kept(&plain(), Format::Mitsuba, "approximated"), set(&["tracing.ray_offset"]));
    for format in [Format::Blender, Format::Usd, Format::Gltf] {
        assert!(kept(&plain(), format, "approximated").contains("material.shell.base_color"), "{format}");
    }
    assert_eq!(kept(&plain(), Format::Gltf, "lost"), set(&["light.ball.radius"]));
    assert!(kept(&plain(), Format::Pbrt, "lost").is_empty());
    assert!(kept(&plain(), Format::Pbrt, "exact").contains("material.shell.base_color"));
}

#[test]
fn what_is_lost_is_listed_exactly() {
    let shell = |keys: &[&str]| keys.iter().map(|key| format!("material.shell.{key}")).collect::<Vec<_>>();
    let check = |format: Format, keys: &[&str], more: &[&str]| {
        let keys = shell(keys);
        let all: Vec<&str> = keys.iter().map(String::as_str).chain(more.iter().copied()).collect();
        assert_eq!(kept(&full(), format, "lost"), lost(&all), "{format}");
    };
    let drawn = ["anisotropy_rotation", "anisotropy_strength"];
    let sheen = ["sheen_color", "sheen_roughness"];
    let second = ["second_lobe_roughness", "second_lobe_weight"];
    let coat = ["clearcoat_factor", "clearcoat_ior", "clearcoat_roughness"];
    let mitsuba = [&drawn[..], &sheen, &["diffuse_roughness", "scatter_distance"]].concat();
    check(Format::Mitsuba, &mitsuba, &[&LOBE[..], &["camera.fy", "camera.cx"]].concat());
    check(Format::Blender, &[], &LOBE);
    check(Format::Usd, &[&drawn[..], &second].concat(), &[]);
    let gltf = [&second[..], &["diffuse_roughness", "scatter_distance", "clearcoat_ior"]].concat();
    let lights = ["light.ball.radius", "light.room.azimuth", "light.room.scale", "light.sky.radiance"];
    let lens = ["camera.cx", "camera.aperture_radius", "camera.focus_distance"];
    check(Format::Gltf, &gltf, &[&LOBE[..], &lights, &lens].concat());
    let pbrt =
        [&drawn[..], &sheen, &coat, &["diffuse_roughness", "scatter_distance", "metallic", "energy_compensation"]]
            .concat();
    check(Format::Pbrt, &pbrt, &LOBE);
}
