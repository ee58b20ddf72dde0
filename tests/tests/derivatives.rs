//! Every freed name's derivative image against central differences of whole renders with the same random numbers.
//!
//! The forward derivative is that of the estimator with its paths held fixed, so the differences are taken along the same
//! paths. They are compared along one direction, J from another seed: <J', D> / <J', J> must be 1 within 1 %.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_scene::files::DirectoryFiles;
use gonio_scene::film::{PixelSet, Tile};
use gonio_scene::{Assets, Capture, Parameter};
use gonio_tests::captures;
use gonio_tracer::{Prepared, Stage, TileTask};
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;

const SAMPLES_PER_HALF: u32 = 8;

/// All channels of all pixels of photo 0, mean of the halves, plane after plane.
fn planes(prepared: &Prepared, along: &Prepared, seed: u64) -> Vec<Vec<f64>> {
    let (width, height) = prepared.size(0).unwrap();
    let tiles: Vec<Tile> = Tile::cover(width, height).collect();
    let count = 1 + prepared.planes();
    let films: Vec<Vec<Vec<f64>>> = tiles
        .par_iter()
        .map(|tile| {
            let pixels = PixelSet::from_flags(std::iter::repeat_n(true, tile.len()));
            let task = TileTask {
                photo: 0,
                tile: *tile,
                pixels: &pixels,
                samples: 0..SAMPLES_PER_HALF,
                difference_samples: 0,
                forward_samples: 0,
                seed,
            };
            let film = prepared.render_along(along, &task, &AtomicBool::new(false)).unwrap();
            (0..count)
                .map(|plane| {
                    (0..tile.len() * 3)
                        .map(|k| {
                            let channel = plane * 3 + k % 3;
                            f64::from(film.pixel(0, k / 3)[channel] + film.pixel(1, k / 3)[channel]) / 2.0
                        })
                        .collect()
                })
                .collect()
        })
        .collect();
    (0..count).map(|plane| films.iter().flat_map(|f| f[plane].clone()).collect()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// The derivative image of one parameter, channels of other colours left at zero.
fn column(capture: &Capture, all: &[Vec<f64>], parameter: &Parameter, columns: &[Parameter]) -> Vec<f64> {
    use gonio_scene::derivative::{Contribution, Plan};
    let plan = Plan::new(capture, columns).unwrap();
    let index = columns.iter().position(|c| c.name == parameter.name).unwrap();
    let mut out = vec![0.0; all[0].len()];
    for part in &plan.columns[index] {
        let Contribution::Plane { plane, channel, factor } = part else { panic!("no film plane") };
        for (k, value) in out.iter_mut().enumerate() {
            if channel.is_none_or(|c| c == k % 3) {
                *value += factor * all[1 + plane][k];
            }
        }
    }
    out
}

fn check(folder: &str, names: &[&str]) {
    let files = DirectoryFiles::new(captures().join(folder));
    let capture = Capture::read(&files).unwrap();
    let stage = Stage::new(capture.clone(), Assets::load(&capture, &files).unwrap());
    let names: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
    let columns = capture.parameters(&names, &[]).unwrap();
    let with = stage.prepare(&[], &columns).unwrap();
    let (first, second) = (planes(&with, &with, 1), planes(&with, &with, 2));
    for parameter in &columns {
        let ours = column(&capture, &first, parameter, &columns);
        let probe = column(&capture, &second, parameter, &columns);
        let step = 2e-3 * parameter.value.abs().max(0.1);
        let at = |by: f64| {
            let numbers: Vec<_> = parameter.numbers(parameter.value + by).collect();
            planes(&stage.prepare(&numbers, &[]).unwrap(), &with, 1).remove(0)
        };
        let difference: Vec<f64> =
            at(step).iter().zip(at(-step)).map(|(plus, minus)| (plus - minus) / (2.0 * step)).collect();
        let ratio = dot(&probe, &difference) / dot(&probe, &ours);
        println!("{folder} {}: {ratio:.4}", parameter.name);
        assert!(dot(&probe, &ours) > 0.0, "{folder} {}: the derivative is zero", parameter.name);
        assert!((ratio - 1.0).abs() < 0.01, "{folder} {}: {ratio}", parameter.name);
    }
}

#[test]
fn materials_under_a_point_light() {
    check(
        "reference/plastic-bracket-board-point",
        &[
            "material.m.base_color",
            "material.m.roughness",
            "material.m.ior",
            "material.b.base_color",
            "light.led.intensity",
        ],
    );
}

#[test]
fn interreflections_under_a_sphere_light() {
    check(
        "reference/box-interreflection",
        &[
            "material.w.base_color",
            "material.r.base_color",
            "material.m.base_color",
            "material.m.roughness",
            "light.lamp.intensity",
        ],
    );
}

#[test]
fn materials_under_a_map() {
    check(
        "reference/plastic-plug-board-sky",
        &["material.m.base_color", "material.m.roughness", "material.m.ior", "light.sky.scale"],
    );
}

#[test]
fn a_metal_under_a_map() {
    check("reference/conductor-knob-sky", &["material.m.roughness", "material.m.eta", "material.m.k"]);
}

#[test]
fn a_directional_light_and_a_constant_sky() {
    check("reference/directional-off-centre", &["light.sun.irradiance", "material.m.ior"]);
    check("reference/plastic-furnace", &["light.env.radiance", "material.m.roughness"]);
}
