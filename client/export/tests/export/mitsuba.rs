//! Mitsuba's scenes.

use crate::fixture::{exported, full, json, plain, text};
use gonio_export::Format;

#[test]
fn a_plastic_is_roughplastic_with_its_numbers_as_they_are() {
    let export = exported(&plain(), Format::Mitsuba);
    let scene = &json(&export, "scenes.json")["00"];
    let shell = &scene["material-shell"];
    assert_eq!(shell["type"], "roughplastic");
    assert_eq!(shell["distribution"], "ggx");
    assert_eq!(shell["nonlinear"], true);
    assert!((shell["alpha"].as_f64().unwrap() - 0.16).abs() < 1e-12);
    assert_eq!(shell["int_ior"], 1.5);
    assert_eq!(shell["diffuse_reflectance"]["value"], serde_json::json!([0.5, 0.2, 0.8]));
    // The lamp moves with the camera, and is alone in the first photo.
    assert_eq!(scene["lamp-0"]["position"], serde_json::json!([0.6, 0.0, 1.0]));
    assert!(scene["lamp-1"].is_null());
    let other = &json(&export, "scenes.json")["01"];
    assert_eq!(other["lamp-0"]["position"], serde_json::json!([-0.1, 0.0, 2.0]));
    let radiance = other["lamp-1"]["emitter"]["radiance"]["value"][0].as_f64().unwrap();
    assert!((radiance - 1.0 / (std::f64::consts::PI * 0.01)).abs() < 1e-9);
    // tan(fov / 2) = 20 / 60.
    let fov = scene["sensor"]["fov"].as_f64().unwrap();
    assert!((fov - 36.869_897_645_844_02).abs() < 1e-9, "{fov}");
}

#[test]
fn the_file_and_the_object_say_the_same() {
    for description in [plain(), full()] {
        let export = exported(&description, Format::Mitsuba);
        for (name, object) in json(&export, "scenes.json").as_object().unwrap() {
            let xml = text(&export, &format!("{name}.xml"));
            let mut numbers = Vec::new();
            collect(object, &mut numbers);
            assert!(numbers.len() > 40);
            for number in numbers {
                assert!(xml.contains(&number), "{name}.xml: {number}");
            }
            let opened = xml.matches("<bsdf ").count() + xml.matches("<shape ").count();
            assert_eq!(opened, xml.matches("</bsdf>").count() + xml.matches("</shape>").count());
            for file in xml.split("name=\"filename\" value=\"").skip(1) {
                let file = file.split('"').next().unwrap();
                assert!(export.files.contains_key(file), "{file}");
            }
        }
    }
}

/// Every number of a description, as XML has it.
fn collect(value: &serde_json::Value, into: &mut Vec<String>) {
    match value {
        serde_json::Value::Number(number) => into.push(number.as_f64().unwrap().to_string()),
        serde_json::Value::Array(list) => list.iter().for_each(|entry| collect(entry, into)),
        serde_json::Value::Object(entries) => entries.values().for_each(|entry| collect(entry, into)),
        _ => {}
    }
}

#[test]
fn a_coat_keeps_the_light_along_the_normal() {
    let coated = plain().replace("ior = 1.5\n", "ior = 1.5\nclearcoat_factor = 1.0\nclearcoat_ior = 1.5\n");
    let shell = &json(&exported(&coated, Format::Mitsuba), "scenes.json")["00"]["material-shell"];
    let weight = shell["weight"].as_f64().unwrap();
    // Against air, 1.000277, as the renderer has it.
    let ratio = 1.5 / 1.000_277;
    let normal = ((ratio - 1.0) / (ratio + 1.0_f64)).powi(2);
    assert!((weight - (1.0 - (1.0 - normal).powi(2))).abs() < 1e-6, "{weight}");
    // The mixed lobe is the coat's own.
    let factor = shell["second"]["specular_reflectance"]["value"].as_f64().unwrap();
    assert!((factor * weight - 1.0).abs() < 1e-12);
    assert_eq!(shell["second"]["diffuse_reflectance"]["value"], serde_json::json!([0.0, 0.0, 0.0]));
    let base = shell["first"]["diffuse_reflectance"]["value"][0].as_f64().unwrap();
    assert!(base < 0.5 && base > 0.45, "{base}");
}

#[test]
fn a_constant_beside_a_map_goes_into_its_pixels() {
    let export = exported(&full(), Format::Mitsuba);
    let sky = &json(&export, "scenes.json")["01"]["sky"];
    assert_eq!((&sky["type"], &sky["scale"]), (&"envmap".into(), &1.0.into()));
    let file = sky["filename"]["file"].as_str().unwrap();
    let mut files = gonio_scene::files::MemoryFiles::default();
    files.0.insert(file.to_owned(), std::sync::Arc::from(export.files[file].as_slice()));
    let image = gonio_scene::image::read(&files, file).unwrap();
    assert_eq!(image.pixels[3], [6.1, 2.2, 1.3]);
}
