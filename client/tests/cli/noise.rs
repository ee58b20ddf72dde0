//! `gonio noise` on photographs whose noise is known, made here by other code than measures it.

use crate::fixture::{gonio, json, refused, succeeds};
use gonio_scene::image::{Image, write_exr};
use image::codecs::jpeg::JpegEncoder;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};
use std::path::Path;

const WIDTH: u32 = 480;
const HEIGHT: u32 = 320;
/// Read and shot noise of the photographs, in light.
const TRUTH: [f64; 2] = [0.004, 0.0006];

/// A normally distributed number (Box and Muller).
fn normal(random: &mut Xoshiro256PlusPlus) -> f64 {
    let mut uniform = || (random.next_u64() >> 11) as f64 / 9_007_199_254_740_992.0;
    (-2.0 * (1.0 - uniform()).ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()
}

/// The light of 24 even patches of other brightness in every channel, with noise.
fn light(seed: u64, gain: f64) -> Image {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let pixels = (0..WIDTH * HEIGHT).map(|k| {
        let patch = (k % WIDTH / 80 + 6 * (k / WIDTH / 80)) as usize;
        [patch, 23 - patch, patch * 7 % 24].map(|level| {
            let light = gain * (0.03 + 0.034 * level as f64);
            (light + normal(&mut random) * (TRUTH[0] * TRUTH[0] + TRUTH[1] * light).sqrt()) as f32
        })
    });
    Image { width: WIDTH, height: HEIGHT, pixels: pixels.collect() }
}

fn jpeg(file: &Path, light: &Image) {
    let code = |light: f32| {
        let light = f64::from(light.clamp(0.0, 1.0));
        let value = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
        (255.0 * value).round() as u8
    };
    let bytes: Vec<u8> = light.pixels.iter().flatten().map(|value| code(*value)).collect();
    let mut out = Vec::new();
    JpegEncoder::new_with_quality(&mut out, 95)
        .encode(&bytes, light.width, light.height, image::ExtendedColorType::Rgb8)
        .unwrap();
    std::fs::write(file, out).unwrap();
}

/// Checks read and shot noise in light of every channel against the truth.
fn holds(told: &serde_json::Value, tolerance: f64) {
    for channel in ["red", "green", "blue"] {
        for (name, truth) in ["read_noise", "shot_noise"].into_iter().zip(TRUTH) {
            let found = told[channel]["light"][name].as_f64().unwrap();
            println!("{channel} {name}: {found:.3e}, {:+.1} %", 100.0 * (found / truth - 1.0));
            assert!((found / truth - 1.0).abs() < tolerance, "{channel} {name} {found} {truth}: {told}");
        }
    }
}

#[test]
fn linear_bursts_give_the_noise_within_3_percent_and_a_photo_alone_within_30() {
    let top = tempfile::tempdir().unwrap();
    for k in 0..4 {
        write_exr(&top.path().join(format!("{k}.exr")), &light(k, 1.0)).unwrap();
    }
    let burst = ["noise", "0.exr", "1.exr", "2.exr", "3.exr", "--out", "sensor.toml", "--json"];
    let told = json(&succeeds(top.path(), &burst));
    assert_eq!((&told["correlated"], &told["response"]), (&false.into(), &"linear".into()), "{told}");
    assert_eq!(told["groups"].as_array().unwrap().len(), 1);
    holds(&told, 0.03);
    let lines = std::fs::read_to_string(top.path().join("sensor.toml")).unwrap();
    assert!(lines.contains("[sensor]\nread_noise = 4.") || lines.contains("[sensor]\nread_noise = 3.9"), "{lines}");
    assert!(std::fs::read_to_string(top.path().join("sensor.svg")).unwrap().ends_with("</svg>\n"));
    // Pairs at two exposures are two bursts; a photo alone is searched for flat tiles.
    write_exr(&top.path().join("dark.exr"), &light(8, 0.3)).unwrap();
    let told = json(&succeeds(top.path(), &["noise", "0.exr", "dark.exr", "1.exr", "--json"]));
    assert_eq!(told["groups"], serde_json::json!([[0, 2], [1]]));
    // Of a photo alone red's shot noise comes out 22 % low: the command says so.
    let output = gonio(top.path(), &["noise", "0.exr", "--json"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("there is no burst of one scene"));
    holds(&json(&String::from_utf8(output.stdout).unwrap()), 0.3);
}

#[test]
fn jpegs_of_quality_95_give_the_noise_of_the_light_within_30_percent() {
    let top = tempfile::tempdir().unwrap();
    for k in 0..6 {
        jpeg(&top.path().join(format!("{k}.jpg")), &light(20 + k, 1.0));
    }
    let photos = ["0.jpg", "1.jpg", "2.jpg", "3.jpg", "4.jpg", "5.jpg"];
    let output = gonio(top.path(), &[&["noise"], &photos[..], &["--json"]].concat());
    assert!(String::from_utf8_lossy(&output.stderr).contains("neighbours are correlated"));
    let told = json(&String::from_utf8(output.stdout).unwrap());
    assert_eq!(told["response"], "srgb");
    holds(&told, 0.3);
    assert!(told["sensor"].as_str().unwrap().contains("response = \"srgb\""), "{told}");
}

#[test]
fn smoothed_photos_are_said_to_have_fewer_observations() {
    let top = tempfile::tempdir().unwrap();
    for k in 0..2 {
        let sharp = light(40 + k, 1.0);
        // The mean over 2 x 2 pixels: a quarter of the variance, and a pixel counts for a quarter of an observation.
        let mean = |x: u32, y: u32, c: usize| {
            let at = |x: u32, y: u32| sharp.pixels[(y.min(HEIGHT - 1) * WIDTH + x.min(WIDTH - 1)) as usize][c];
            (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) / 4.0
        };
        let pixels = (0..WIDTH * HEIGHT).map(|k| [0, 1, 2].map(|c| mean(k % WIDTH, k / WIDTH, c))).collect();
        write_exr(&top.path().join(format!("{k}.exr")), &Image { width: WIDTH, height: HEIGHT, pixels }).unwrap();
    }
    let told = json(&succeeds(top.path(), &["noise", "0.exr", "1.exr", "--json"]));
    assert_eq!(told["correlated"], true);
    for channel in ["red", "green", "blue"] {
        let share = told[channel]["effective_observations_per_pixel"].as_f64().unwrap();
        assert!((share - 0.25).abs() < 0.03, "{channel} {share}");
    }
    holds(&told, 0.3);
    let said = String::from_utf8(gonio(top.path(), &["noise", "0.exr", "1.exr"]).stdout).unwrap();
    assert!(said.contains("neighbours are correlated") && said.contains("read_noise = "), "{said}");
}

#[test]
fn what_says_nothing_about_noise_is_refused_by_file_and_mend() {
    let top = tempfile::tempdir().unwrap();
    let at = top.path();
    let mut gray = light(1, 1.0);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    gray.pixels.iter_mut().for_each(|pixel| *pixel = [0.4 + 0.01 * normal(&mut random) as f32; 3]);
    write_exr(&at.join("gray.exr"), &gray).unwrap();
    refused(at, &["noise", "gray.exr"], &["gray.exr: shows one brightness in red", "darker or brighter"]);
    gray.pixels.fill([2.0; 3]);
    write_exr(&at.join("white.exr"), &gray).unwrap();
    refused(at, &["noise", "white.exr"], &["white.exr: ", "too few flat pixels", "tripod"]);
    write_exr(&at.join("small.exr"), &Image { width: 2, height: 2, pixels: vec![[0.5; 3]; 4] }).unwrap();
    refused(at, &["noise", "gray.exr", "small.exr"], &["small.exr: is 2 x 2 pixels", "one size"]);
    refused(at, &["noise", "gray.exr", "--patch", "400,0,100,10"], &["gray.exr: --patch: ", "inside of the photo"]);
    refused(at, &["noise", "gray.exr", "--response", "log"], &["--response", "gamma:EXPONENT"]);
    refused(at, &["noise", "none.exr"], &["none.exr"]);
}
