//! Numbers of the sensor, planted in photographs that the farm itself renders, and found again by a fit through the
//! embedded farm: three matt patches under a known lamp, two exposures.
//!
//! Nothing but the sensor is free, and the photographs carry no noise but the render's, so each number must come back
//! within 3 standard errors or 0.001, and from the null.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio::farm::Farm;
use gonio_fit::evaluate::Evaluate;
use gonio_fit::{Options, fit};
use gonio_scene::files::MemoryFiles;
use gonio_scene::image::{Image, encode_exr};
use gonio_scene::{Capture, EvaluationRequest, Output, SensorStage};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Three stripes side by side in the plane z = 0, facing +z.
fn stripe(index: usize) -> String {
    let left = -0.6 + 0.4 * index as f64;
    let right = left + 0.4;
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         element face 2\nproperty list uchar int vertex_indices\nend_header\n\
         {left} -0.5 0\n{right} -0.5 0\n{right} 0.5 0\n{left} 0.5 0\n3 0 1 2\n3 0 2 3\n"
    )
}

fn files(sensor: &str, fit: &str) -> MemoryFiles {
    let mut toml = format!(
        "format = 1\nname = \"stripes\"\n\
         [camera]\nwidth = 32\nheight = 24\nfx = 32.0\nfy = 32.0\ncx = 15.0\ncy = 12.5\n\
         [sensor]\nread_noise = 0.001\n{sensor}\n\
         [[light]]\nname = \"lamp\"\nkind = \"point\"\nposition = [0.1, 0.2, 0.8]\nintensity = [1.0, 0.9, 0.8]\n\
         [fit]\nparameters = [{fit}]\n"
    );
    let mut files = MemoryFiles::default();
    for (i, color) in [[0.7, 0.2, 0.1], [0.2, 0.6, 0.3], [0.1, 0.3, 0.8]].iter().enumerate() {
        toml += &format!(
            "[[material]]\nname = \"m{i}\"\nmodel = \"lambert\"\nbase_color = {color:?}\n\
             [[object]]\nname = \"o{i}\"\nmesh = \"{i}.ply\"\nmaterial = \"m{i}\"\n\
             object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
        );
        files.0.insert(format!("{i}.ply"), Arc::from(stripe(i).as_bytes()));
    }
    for (i, exposure) in [1.0, 2.5].iter().enumerate() {
        toml += &format!(
            "[[photo]]\nfile = \"{i}.exr\"\nexposure = {exposure:?}\n\
             camera_to_world = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 1], [0, 0, 0, 1]]\n"
        );
    }
    files.0.insert("capture.toml".into(), Arc::from(toml.as_bytes()));
    files
}

/// Renders with the planted sensor, and frees the planted names from the null on.
fn recovers(planted: &str, truth: &[(&str, f64)]) {
    let farm = Farm::embedded(0).unwrap();
    let real = files(planted, "");
    let capture = Capture::read(&real).unwrap();
    let request = EvaluationRequest { photos: vec![0, 1], samples: 64, seed: 77, output: Output::Films, ..request() };
    let answer = farm.open(&real).unwrap().evaluate(&request, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(answer.invalid_samples, 0);

    let names: Vec<String> = truth.iter().map(|(name, _)| format!("\"sensor.{name}\"")).collect();
    let mut start = files("", &names.join(", "));
    for film in &answer.films {
        let photo = SensorStage::of(&capture, film.photo).photo_values(film);
        let pixels = (0..photo.channels[0].len()).map(|i| [0, 1, 2].map(|c| photo.channels[c][i])).collect();
        let image = Image { width: photo.width, height: photo.height, pixels };
        let name = format!("{}.exr", film.photo);
        start.0.insert(name.clone(), encode_exr(&name, &image).unwrap().into());
    }
    let capture = Capture::read(&start).unwrap();
    let mut open = farm.open(&start).unwrap();
    let result = fit(&capture, &mut open, &Options::default(), &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(result.converged, "{planted}");
    for ((name, expected), found) in truth.iter().zip(&result.parameters) {
        let error = found.standard_error.unwrap();
        println!("{name}: {} +- {error}, planted {expected}", found.value);
        assert_eq!(found.name, format!("sensor.{name}"));
        assert!((found.value - expected).abs() < (3.0 * error).max(1e-3), "{name}: {} +- {error}", found.value);
        assert!(error < 0.05, "{name}: +- {error}");
    }
}

fn request() -> EvaluationRequest {
    EvaluationRequest {
        numbers: vec![],
        columns: vec![],
        photos: vec![],
        samples: 2,
        difference_samples: 0,
        forward_samples: 0,
        seed: 0,
        output: Output::Films,
    }
}

#[test]
fn a_fit_finds_each_planted_number() {
    recovers("vignetting = [-0.3, 0.1]", &[("vignetting.k1", -0.3), ("vignetting.k2", 0.1)]);
    recovers("black_level = 0.03", &[("black_level", 0.03)]);
    recovers("gamma = 1.15", &[("gamma", 1.15)]);
    let pairs = [("rg", 0.05), ("rb", 0.01), ("gr", 0.03), ("gb", 0.02), ("br", 0.0), ("bg", 0.04)];
    let names = pairs.map(|(pair, _)| format!("crosstalk.{pair}"));
    let truth: Vec<_> = names.iter().zip(pairs).map(|(name, (_, value))| (name.as_str(), value)).collect();
    recovers("crosstalk = [0.05, 0.01, 0.03, 0.02, 0.0, 0.04]", &truth);
}

#[test]
fn a_fit_finds_several_at_once() {
    let planted = "vignetting = [-0.2, 0.0]\ncrosstalk = [0.05, 0, 0, 0, 0, 0]\nblack_level = 0.02\ngamma = 0.9";
    let truth = [("vignetting.k1", -0.2), ("crosstalk.rg", 0.05), ("black_level", 0.02), ("gamma", 0.9)];
    recovers(planted, &truth);
}
