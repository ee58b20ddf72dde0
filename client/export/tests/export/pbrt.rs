//! pbrt's scenes.

use crate::fixture::{exported, full, plain, text};
use gonio_export::Format;

#[test]
fn a_plastic_is_coateddiffuse_with_its_numbers_as_they_are() {
    let scene = text(&exported(&plain(), Format::Pbrt), "00.pbrt");
    assert!(
        scene.contains(
            "\"string type\" [ \"coateddiffuse\" ] \"rgb reflectance\" [ 0.5 0.2 0.8 ] \"float eta\" [ 1.5 ]"
        )
    );
    assert!(scene.contains("\"bool remaproughness\" [ false ]"));
    let alpha = scene.split("\"float roughness\" [ ").nth(1).unwrap().split(' ').next().unwrap();
    assert!((alpha.parse::<f64>().unwrap() - 0.16).abs() < 1e-12);
    let window = scene.split("\"float screenwindow\" [ ").nth(1).unwrap().split(" ]").next().unwrap();
    let window: Vec<f64> = window.split(' ').map(|x| x.parse().unwrap()).collect();
    let third = 1.0 / 3.0;
    assert!(window.iter().zip([-third, third, -0.25, 0.25]).all(|(a, b)| (a - b).abs() < 1e-12), "{window:?}");
    assert!(scene.contains("LightSource \"point\" \"rgb I\" [ 0.4 0.2 0.1 ] \"point3 from\" [ 0.6 0 1 ]"));
}

#[test]
fn the_camera_sees_a_point_where_the_photo_does() {
    let scene = text(&exported(&plain(), Format::Pbrt), "00.pbrt");
    let numbers = scene.split("Transform [ ").nth(1).unwrap().split(" ]").next().unwrap();
    let m: Vec<f64> = numbers.split(' ').map(|x| x.parse().unwrap()).collect();
    // In front of the camera, to its right and below: by hand, camera coordinates (0.1, 0.2, 1).
    let world = [0.6, -0.2, 0.0];
    let seen: Vec<f64> = (0..3).map(|i| (0..3).map(|k| m[4 * k + i] * world[k]).sum::<f64>() + m[12 + i]).collect();
    // pbrt's y points up.
    assert!(seen.iter().zip([0.1, -0.2, 1.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{seen:?}");
}

#[test]
fn files_that_are_named_are_there() {
    let export = exported(&full(), Format::Pbrt);
    let scene = text(&export, "01.pbrt");
    let named: Vec<&str> =
        scene.split("\"string filename\" [ \"").skip(2).map(|s| s.split('"').next().unwrap()).collect();
    assert_eq!(named.len(), 3);
    assert!(named.iter().all(|file| export.files.contains_key(*file)), "{named:?}");
    assert_eq!(scene.matches("AttributeBegin").count(), scene.matches("AttributeEnd").count());
}
