//! `sensor.py` against the sensor stage of renders.

use crate::fixture::{exported, full, text, written};
use crate::programs::python;
use gonio_export::Format;
use gonio_scene::{Capture, SensorStage};

/// A light that needs every step.
fn light(x: usize, y: usize) -> [f64; 3] {
    [0.01 * x as f64, 0.02 * y as f64, 0.3]
}

#[test]
fn the_numbers_stand_in_the_file() {
    let code = text(&exported(&full(), Format::Mitsuba), "sensor.py");
    assert!(!code.contains("@CAPTURE@"));
    for number in
        ["\"black_level\":0.02", "\"gamma\":1.1", "\"clip_level\":0.9", "\"response\":\"srgb\"", "\"factor\":2.0"]
    {
        assert!(code.contains(number), "{number}");
    }
}

#[test]
fn photo_values_are_those_of_gonios_stage() {
    let Some(python) = python(&["numpy"]) else { return };
    // Without glare, which the stage does not do.
    let description = full().replace("glare_fraction = 0.05", "glare_fraction = 0.0");
    let folder = written(&exported(&description, Format::Gltf));
    let program = "import json, numpy as np, sensor\n\
        y, x = np.mgrid[0:30, 0:40]\n\
        image = np.stack([0.01 * x, 0.02 * y, 0.3 + 0 * x], axis=-1)\n\
        print(json.dumps(sensor.photograph(image, '00')[::7, ::9].tolist()))\n\
        noisy = sensor.photograph(image, '00', rng=np.random.default_rng(1)) - sensor.photograph(image, '00')\n\
        assert 0.01 < noisy.std() < 0.05, noisy.std()\n";
    let output = python(program, folder.path());
    let found: Vec<Vec<[f64; 3]>> = serde_json::from_str(&output).unwrap();
    let capture = Capture::parse(&description).unwrap();
    let stage = SensorStage::of(&capture, 0);
    for (i, row) in found.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            let (x, y) = (9 * j, 7 * i);
            let expected = stage.value(light(x, y).map(|l| l * 2.0), x, y).value;
            assert!(value.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{x} {y}: {value:?} {expected:?}");
        }
    }
}
