//! The data of Blender's script.

use crate::fixture::{exported, full, json, plain, text};
use gonio_export::Format;

/// b (1 - F_in) / (1 - b F_in) at index 1.5, F_in = 0.5963 (Walsh 1926), of 0.5, 0.2 and 0.8.
const SMOOTH: [f64; 3] = [0.2877, 0.0917, 0.6177];

/// What a rough boundary without energy compensation shows of that, by values of Mitsuba 3.9's `roughplastic` at roughness 0.4.
const ROUGH: [f64; 3] = [0.9578, 0.9953, 0.9007];

#[test]
fn a_plastic_has_the_colour_of_renderers_without_reflection_below() {
    let colour =
        |toml: &str| json(&exported(toml, Format::Blender), "scene.json")["materials"][0]["lobes"][0]["color"].clone();
    let smooth = colour(&plain().replace("roughness = 0.4", "roughness = 0.05\nenergy_compensation = true"));
    let rough = colour(&plain());
    for c in 0..3 {
        let (smooth, rough) = (smooth[c].as_f64().unwrap(), rough[c].as_f64().unwrap());
        assert!((smooth / SMOOTH[c] - 1.0).abs() < 5e-3, "{smooth}");
        // The lobe of a rough boundary leaves more to the base than 1 - F_out: 0.5 to 2 % here.
        let ratio = rough / (SMOOTH[c] * ROUGH[c]);
        assert!((0.975..1.0).contains(&ratio), "{rough} {ratio}");
    }
}

#[test]
fn the_data_name_files_that_are_there() {
    let export = exported(&full(), Format::Blender);
    let scene = json(&export, "scene.json");
    // The absent object is not there.
    assert_eq!(scene["objects"].as_array().unwrap().len(), 2);
    for object in scene["objects"].as_array().unwrap() {
        assert!(export.files.contains_key(object["mesh"].as_str().unwrap()));
        assert!(object["material"].as_u64().unwrap() < 3);
    }
    let photo = &scene["photos"]["01"];
    assert!(export.files.contains_key(photo["map"]["file"].as_str().unwrap()));
    // The dark lamp is left out; the led, the sun and the ball shine.
    let kinds: Vec<&str> = photo["lamps"].as_array().unwrap().iter().map(|l| l["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["point", "directional", "sphere"]);
    // A sun shines along the third axis's opposite: (0, 3, -4) / 5.
    let turn = &photo["lamps"][1]["turn"];
    let along: Vec<f64> = (0..3).map(|k| -turn[k][2].as_f64().unwrap()).collect();
    assert!(along.iter().zip([0.0, 0.6, -0.8]).all(|(a, b)| (a - b).abs() < 1e-12), "{along:?}");
    assert!(text(&export, "scene.py").contains("import bpy"));
}
