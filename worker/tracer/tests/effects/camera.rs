//! A thin lens and veiling glare, on the edge of a board that parallel light falls on.

use crate::fixture::{SIDE, Text, distance, film, plane, radiance};

/// The board ends at x = 0, in the middle of the photo; beyond it is nothing.
fn edge(camera: &str) -> Text {
    Text {
        camera: camera.to_owned(),
        board: "translation = [-2, 0, 0]".into(),
        block: "presence = 0".into(),
        lights: "[[light]]\nname = \"sun\"\nkind = \"directional\"\ndirection = [0, 0, -1]\nirradiance = [1, 1, 1]\n"
            .into(),
    }
}

/// The light of each column of pixels, as a share of the board's.
fn columns(image: &[f64]) -> Vec<f64> {
    let side = SIDE as usize;
    let board = 0.8 / std::f64::consts::PI;
    let column = |x: usize| (0..side).map(|y| image[3 * (y * side + x)]).sum::<f64>() / side as f64 / board;
    (0..side).map(column).collect()
}

/// The mean over each column's pixels of `share`, a function of the distance to the right of the edge in pixels.
fn expected(share: &dyn Fn(f64) -> f64) -> Vec<f64> {
    let steps = 200;
    let at = |x: u32, k: i32| share(f64::from(x) + (f64::from(k) + 0.5) / f64::from(steps) - f64::from(SIDE) / 2.0);
    (0..SIDE).map(|x| (0..steps).map(|k| at(x, k)).sum::<f64>() / f64::from(steps)).collect()
}

fn compare(found: &[f64], expected: &[f64], tolerance: f64) {
    for (x, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() < tolerance, "column {x}: {found:.4}, not {expected:.4}");
    }
}

/// The edge blurs by the disk of confusion, of radius f a |1/depth - 1/focus| pixels, in front of the focus and behind.
#[test]
fn a_lens_blurs_an_edge_by_its_circle_of_confusion() {
    for (aperture, focus) in [(0.1, 0.4), (0.15, 1.0), (0.1, 0.6)] {
        let radius = 40.0 * aperture * (1.0 / 0.6f64 - 1.0 / focus).abs();
        let share = |x: f64| {
            let t = (-x / radius.max(1e-9)).clamp(-1.0, 1.0);
            0.5 + (t * (1.0 - t * t).sqrt() + libm::asin(t)) / std::f64::consts::PI
        };
        let image = edge(&format!("aperture_radius = {aperture}\nfocus_distance = {focus}")).render(256);
        compare(&columns(&image), &expected(&share), 0.01);
    }
}

/// Glare leaves 1 - f of the edge and adds f of an edge as soft as its Gaussian.
#[test]
fn glare_of_an_edge_is_an_error_function() {
    for (fraction, width) in [(0.3, 3.0), (1.0, 1.5), (0.05, 12.0)] {
        let share = |x: f64| {
            let soft = 0.5 * libm::erfc(x / width / 2f64.sqrt());
            (1.0 - fraction) * f64::from(u8::from(x < 0.0)) + fraction * soft
        };
        let image = edge(&format!("glare_fraction = {fraction:?}\nglare_width = {width}")).render(256);
        compare(&columns(&image), &expected(&share), 0.015);
    }
}

/// Off, both leave every bit; their derivatives there are differences against the render that is there anyway.
#[test]
fn lens_and_glare_change_nothing_when_off_and_have_derivatives_there() {
    let plain = Text::default();
    let off = Text { camera: "focus_distance = 0.3\nglare_width = 5".into(), ..Text::default() };
    let image = plain.render(4);
    assert!(image.iter().zip(off.render(4)).all(|(a, b)| a.to_bits() == b.to_bits()));
    let stage = off.stage();
    for (name, step) in [("camera.aperture_radius", 2e-3), ("camera.glare_fraction", 0.25)] {
        let prepared = stage.prepare(&[], &off.columns(&[name])).unwrap();
        let found = plane(&film(&prepared, 0, 4, 0), 1);
        let moved = radiance(&stage.prepare(&[(name.to_owned(), step)], &[]).unwrap(), 4);
        let difference: Vec<f64> = moved.iter().zip(&image).map(|(a, b)| (a - b) / step).collect();
        let error = distance(&found, &difference);
        assert!(error < 1e-3 && found.iter().any(|v| *v != 0.0), "{name}: {error}");
    }
}

/// Forward derivatives go through glare as radiance does: a light's is its radiance over its intensity.
#[test]
fn glare_carries_forward_derivatives() {
    let text = Text { camera: "glare_fraction = 0.4\nglare_width = 2".into(), ..Text::default() };
    let prepared = text.stage().prepare(&[], &text.columns(&["light.lamp.intensity"])).unwrap();
    let film = film(&prepared, 0, 8, 0);
    assert!(distance(&plane(&film, 1), &plane(&film, 0)) < 1e-5);
}
