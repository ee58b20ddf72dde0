//! Light that enters a surface at one place and leaves it at another: energy, limits, a plane's closed form, derivatives.

use crate::fixture::{SIDE, Text, assets, distance, film, film_along, lamp, mean, plane, radiance};
use gonio_scene::{Capture, Parameter};
use gonio_tracer::Stage;

const SKY: &str = "[[light]]\nname = \"sky\"\nkind = \"environment\"\nradiance = [1, 1, 1]\n";

/// The board alone, of a material of the fixture, or with the block.
fn stage(material: &str, block: bool, lights: &str) -> (Capture, Stage) {
    let text = Text { block: format!("presence = {}", u8::from(block)), lights: lights.to_owned(), ..Text::default() };
    let mut capture = text.capture();
    capture.objects[0].material = material.to_owned();
    (capture.clone(), Stage::new(capture, assets()))
}

/// Numbers that give both materials a mean free path.
fn free_path(value: f64) -> Vec<(String, f64)> {
    ["white", "glossy"].iter().map(|m| (format!("material.{m}.scatter_distance"), value)).collect()
}

fn at(stage: &Stage, path: f64, samples: u32) -> Vec<f64> {
    radiance(&stage.prepare(&free_path(path), &[]).unwrap(), samples)
}

/// The sum of each channel over those of another image.
fn ratios(a: &[f64], b: &[f64]) -> [f64; 3] {
    let sum = |image: &[f64], c: usize| image.iter().skip(c).step_by(3).sum::<f64>();
    [0, 1, 2].map(|c| sum(a, c) / sum(b, c))
}

/// On a wide board every channel returns what it did, under a sky (which only the directions of a path meet) and under a
/// lamp (which only light samples meet).
#[test]
fn a_flat_slab_keeps_its_energy() {
    for material in ["white", "glossy"] {
        for lights in [SKY.to_owned(), lamp("lamp", "point", [0.3, -0.2, 0.8], 1.0, "")] {
            let (_, stage) = stage(material, false, &lights);
            let plain = at(&stage, 0.0, 128);
            for path in [0.002, 0.01] {
                let found = ratios(&at(&stage, path, 128), &plain);
                println!("{material} {path}: {found:.4?}");
                assert!(found.iter().all(|r| (r - 1.0).abs() < 4e-3), "{material} {path}: {found:?}");
            }
        }
    }
}

/// The shorter the mean free path, the less it shows; far below a pixel it shows nowhere.
#[test]
fn a_short_path_is_no_path() {
    let lights = lamp("lamp", "sphere", [0.3, -0.2, 0.8], 1.0, "radius = 0.05\n");
    let (_, stage) = stage("white", true, &lights);
    let plain = at(&stage, 0.0, 128);
    let off = [0.02, 0.005, 1e-4].map(|path| distance(&at(&stage, path, 128), &plain));
    println!("{off:.4?}");
    // What is left is the noise of light between board and block, which takes other turns.
    assert!(off[0] > 2.0 * off[1] && off[1] > off[2] && off[2] < 0.02, "{off:?}");
    let ratio = mean(&at(&stage, 1e-4, 128)) / mean(&plain);
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
    // Below what rays keep off a surface there is none.
    assert_eq!(at(&stage, 1e-9, 16), at(&stage, 1e-10, 16));
}

/// What leaves a plane beside the edge of a shadow follows from the profile's own integral: parallel light falls on the part
/// of the board that a wall far above does not shade.
#[test]
fn an_edge_of_light_is_blurred_by_the_profile() {
    let path = 0.01;
    // A board that ends at x = 0, lit straight from above: what has left to the other side is lost.
    let text = Text {
        board: "translation = [-2, 0, 0]".into(),
        block: "presence = 0".into(),
        lights: "[[light]]\nname = \"sun\"\nkind = \"directional\"\ndirection = [0, 0, -1]\nirradiance = [1, 1, 1]\n"
            .into(),
        ..Text::default()
    };
    let image = radiance(&text.stage().prepare(&free_path(path), &[]).unwrap(), 256);
    let side = SIDE as usize;
    for (c, albedo) in [0.8f64, 0.7, 0.6].into_iter().enumerate() {
        let d = path / (1.9 - albedo + 3.5 * (albedo - 0.8f64).powi(2));
        // The light of a half plane at a distance: the share of the profile on the near side of a line. By radii: the
        // angle that is cut off at radius r is 2 acos(x / r).
        let lost = |x: f64| {
            let steps = 4000;
            (0..steps)
                .map(|i| {
                    let r = x + 0.4 * (f64::from(i) + 0.5) / f64::from(steps);
                    let profile =
                        (libm::exp(-r / d) + libm::exp(-r / (3.0 * d))) / (8.0 * std::f64::consts::PI * d * r);
                    2.0 * libm::acos(x / r) * r * profile * 0.4 / f64::from(steps)
                })
                .sum::<f64>()
        };
        for column in 0..side / 2 {
            let found = (0..side).map(|y| image[3 * (y * side + column) + c]).sum::<f64>() / side as f64;
            let pixel = 0.6 / 40.0;
            let middle = (side as f64 / 2.0 - column as f64 - 0.5) * pixel;
            let parts = 16;
            let share = (0..parts)
                .map(|k| 1.0 - lost(middle + pixel * ((f64::from(k) + 0.5) / f64::from(parts) - 0.5)))
                .sum::<f64>()
                / f64::from(parts);
            let expected = albedo / std::f64::consts::PI * share;
            assert!((found / expected - 1.0).abs() < 0.01, "channel {c}, column {column}: {found} {expected}");
        }
    }
}

/// The derivative at the null is the difference of two renders along the same random numbers; by its square it is the same
/// for another step, and no bit of the radiance changes.
#[test]
fn the_null_has_a_derivative_by_the_square() {
    let (capture, stage) = stage("white", true, &lamp("lamp", "point", [0.3, -0.2, 0.8], 1.0, ""));
    let plain = at(&stage, 0.0, 64);
    let columns = |step: Option<f64>| -> Vec<Parameter> {
        let names = ["material.glossy.scatter_distance".to_owned()];
        let mut columns = capture.parameters(&names, &[]).unwrap();
        columns.iter_mut().for_each(|c| c.step = step);
        columns
    };
    let by_square = |step: f64| {
        let prepared = stage.prepare(&[], &columns(Some(step))).unwrap();
        let found = film(&prepared, 0, 64, 0);
        assert!(plane(&found, 0).iter().zip(&plain).all(|(a, b)| a.to_bits() == b.to_bits()));
        let moved = stage.prepare(&[("material.glossy.scatter_distance".to_owned(), step)], &[]).unwrap();
        let ends = plane(&film_along(&moved, &prepared, 0, 64, [0, 0]), 0);
        let expected: Vec<f64> = ends.iter().zip(&plain).map(|(a, b)| (a - b) / step).collect();
        assert!(distance(&plane(&found, 1), &expected) < 1e-4);
        expected.iter().map(|d| d / step).collect::<Vec<f64>>()
    };
    let (long, short) = (by_square(0.012), by_square(0.008));
    assert!(long.iter().all(|d| d.is_finite()) && long.iter().any(|d| *d != 0.0));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let alike = dot(&long, &short) / (dot(&long, &long) * dot(&short, &short)).sqrt();
    println!("by the square, two steps: correlation {alike:.3}, size {:.3}", mean(&long) / mean(&short));
    assert!(alike > 0.8, "{alike}");
    let usual = stage.prepare(&[], &columns(None)).unwrap();
    assert!(plane(&film(&usual, 0, 8, 0), 1).iter().any(|d| *d != 0.0));
}
