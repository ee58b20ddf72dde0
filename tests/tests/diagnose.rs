//! What is hidden in a capture is named, and nothing else: small captures whose effects are made outside of the renderer
//! that the diagnosis fits with, through the embedded farm.
//!
//! The whole catalogue at two strengths, and many captures without an effect, take too long for here: they are the example
//! `confusion`.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio::farm::Farm;
use gonio_diagnose::effects::all;
use gonio_diagnose::{Diagnosed, Diagnosis, Options, Verdict};
use gonio_scene::Capture;
use gonio_scene::files::{Files, MemoryFiles};
use gonio_scene::image::{self, encode_exr};
use gonio_tests::hidden::{HELD_OUT, Hidden, diagnosed, hide, named};
use std::sync::{LazyLock, Mutex};

/// One farm; one diagnosis at a time, because each takes every core.
static FARM: LazyLock<Mutex<Farm>> = LazyLock::new(|| Mutex::new(Farm::embedded(0).unwrap()));

const SAMPLES: u32 = 128;

fn diagnose(files: &MemoryFiles, options: &Options) -> Diagnosed {
    // A test that has failed with the farm in its hands has not hurt it.
    let farm = FARM.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let done = diagnosed(&farm, files, options).unwrap();
    let d = &done.diagnosis;
    let (before, after) = (d.base.fit.reduced_chi_square, d.last.fit.reduced_chi_square);
    println!("{:?} {:?}, chi-square {before:.3} -> {after:.3}, {:.1} s", d.verdict, named(d), d.seconds);
    for c in &d.candidates {
        let [gain, error, p] = [c.gain, c.gain_standard_error, c.p_value].map(|x| x.unwrap_or(f64::NAN));
        let why = c.refused_because.as_deref().unwrap_or("added");
        println!("  {}: promised {gain:.4} +- {error:.4}, p {p:.1e}, {why}", c.effect);
    }
    done
}

fn run(effects: &[(&str, f64)], seed: u64, options: &Options) -> Diagnosis {
    let Hidden { files, .. } = hide(effects, seed, SAMPLES);
    diagnose(&files, options).diagnosis
}

/// Everything but these is left out of the catalogue: where the question is not who is confused with whom.
fn only(names: &[&str]) -> Options {
    let without = all().map(|e| e.name.to_owned()).filter(|e| !names.contains(&e.as_str())).collect();
    Options { without, ..Options::default() }
}

/// The effect is in the set of the first finding, and where it leads that set, the numbers are the hidden ones within 3
/// standard errors or 10 %.
fn finds(effect: &str, strength: f64, truth: &[(&str, f64)]) {
    let found = run(&[(effect, strength)], 1, &Options::default());
    assert_eq!(found.verdict, Verdict::Named, "{effect}: {:?}", found.unexplained);
    assert_eq!(found.found.len(), 1, "{effect}: {:?}", named(&found));
    let finding = &found.found[0];
    assert!(finding.effects.iter().any(|e| e == effect), "{effect}: taken for {:?}", finding.effects);
    assert!(finding.held_out.unwrap().log_density_gain > 0.0);
    for (name, hidden) in truth {
        let p = finding.parameters.iter().find(|p| p.name == *name).unwrap();
        let off = (p.value - hidden).abs();
        println!("{name}: {} +- {:?}, hidden {hidden}", p.value, p.standard_error);
        let bound = (3.0 * p.standard_error.unwrap()).max(0.1 * (hidden - p.null.unwrap_or(0.0)).abs());
        assert!(off < bound, "{name}: {} instead of {hidden}, beyond {bound}", p.value);
    }
}

#[test]
fn nothing_is_named_where_nothing_is_hidden() {
    let found = run(&[], 1, &Options::default());
    assert_eq!(found.verdict, Verdict::None, "{:?} {:?}", named(&found), found.unexplained);
}

#[test]
fn vignetting_is_found() {
    finds("vignetting", 1.0, &[("sensor.vignetting.k1", -0.25)]);
}

#[test]
fn a_black_level_is_found() {
    finds("black-level", 1.0, &[("sensor.black_level", 0.02)]);
}

#[test]
fn a_response_is_found() {
    finds("response-gamma", 1.0, &[("sensor.gamma", 1.15)]);
}

/// A mean above the level by the render's noise alone must not speak against it.
#[test]
fn clipping_is_found() {
    finds("clipping", 1.0, &[]);
}

/// One photo knows nearly all of the radius: the quadratic that leaves it out predicts nonsense, fits to parts of the photos do not.
#[test]
fn a_small_lamp_is_found() {
    finds("light-size", 0.35, &[]);
}

/// Beside a pattern of colours, which explains less but renders with less noise.
#[test]
fn light_under_the_surface_is_found() {
    let found = run(&[("translucency", 1.0)], 1, &only(&["translucency", "albedo-variation"]));
    assert!(found.found[0].effects.iter().any(|e| e == "translucency"), "{:?}", named(&found));
}

#[test]
fn light_from_everywhere_is_found() {
    let hidden = [0.030, 0.034, 0.042].map(|x| 0.35 * x);
    let names = ["r", "g", "b"].map(|c| format!("light.ambient.radiance.{c}"));
    let truth: Vec<(&str, f64)> = names.iter().map(String::as_str).zip(hidden).collect();
    finds("ambient-light", 0.35, &truth);
}

#[test]
fn two_effects_are_found_together() {
    let found = run(&[("vignetting", 1.0), ("response-gamma", 1.0)], 2, &Options::default());
    assert_eq!(found.verdict, Verdict::Named);
    assert_eq!(found.found.len(), 2, "{:?}", named(&found));
    for effect in ["vignetting", "response-gamma"] {
        assert!(named(&found).iter().any(|set| set.iter().any(|e| e == effect)), "{effect}: {:?}", named(&found));
    }
}

/// What no effect of the catalogue explains must not get the name of one that it resembles.
#[test]
fn what_the_catalogue_lacks_is_not_misnamed() {
    // The file's numbers of single photos hold the same factors.
    let without = ["light-flicker", "photo-exposure", "photo-balance", "white-balance"].map(str::to_owned).to_vec();
    let options = Options { without, ..Options::default() };
    let found = run(&[("light-flicker", 1.0)], 1, &options);
    assert!(found.found.is_empty(), "{:?}", named(&found));
    assert_ne!(found.verdict, Verdict::Named);
    assert!(found.base.fit.reduced_chi_square > 1.5, "nothing was hidden");
}

/// The numbers of a selection, to the last bit: both models, the base model's fit, every effect's score.
fn bits(done: &Diagnosed) -> Vec<(String, u64)> {
    let mut all = Vec::new();
    for capture in [&done.base_capture, &done.last_capture] {
        all.extend(capture.numbers().into_iter().map(|(name, (value, _))| (name, value.to_bits())));
    }
    let base = &done.diagnosis.base;
    all.extend(base.parameters.iter().map(|p| (p.name.clone(), p.standard_error.unwrap_or(0.0).to_bits())));
    all.push(("chi-square".to_owned(), base.fit.reduced_chi_square.to_bits()));
    let mut scores: Vec<_> =
        done.diagnosis.candidates.iter().map(|c| (c.effect.clone(), c.gain.unwrap_or(0.0).to_bits())).collect();
    scores.sort();
    all.extend(scores);
    all
}

/// The coordinator and the workers are processes of their own.
#[cfg(unix)]
#[test]
fn a_remote_farm_comes_to_the_same_diagnosis_to_the_last_bit() {
    let options = only(&["vignetting", "black-level"]);
    let Hidden { files, .. } = hide(&[("vignetting", 1.0)], 3, SAMPLES);
    let embedded = diagnose(&files, &options);
    let cluster = gonio_tests::cluster::Cluster::start(2);
    let remote = diagnosed(&Farm::connect(&cluster.url).unwrap(), &files, &options).unwrap();
    assert_eq!(named(&embedded.diagnosis), [["vignetting".to_owned()]]);
    // All but how long it took.
    let json = |done: &Diagnosed| {
        let mut d = done.diagnosis.clone();
        (d.seconds, d.base.seconds, d.last.seconds) = (0.0, 0.0, 0.0);
        serde_json::to_string(&d).unwrap()
    };
    assert_eq!(json(&remote), json(&embedded));
    assert_eq!(bits(&remote), bits(&embedded));
}

#[test]
fn photos_that_are_held_out_are_not_looked_at() {
    let options = only(&["vignetting", "black-level", "response-gamma"]);
    let Hidden { mut files, .. } = hide(&[("vignetting", 1.0)], 3, SAMPLES);
    let whole = diagnose(&files, &options);
    assert_eq!(named(&whole.diagnosis), [["vignetting".to_owned()]]);
    let capture = Capture::read(&files).unwrap();
    let path = &capture.photos[HELD_OUT].file;

    let mut photo = image::read(&files, path).unwrap();
    photo.pixels.reverse();
    photo.pixels.iter_mut().for_each(|p| *p = p.map(|v| 0.5 * v));
    files.0.insert(path.clone(), encode_exr(path, &photo).unwrap().into());
    let poisoned = diagnose(&files, &options);
    assert_eq!(bits(&poisoned), bits(&whole));

    files.0.remove(path);
    assert!(files.read(path).is_err());
    let missing = diagnose(&files, &options);
    assert!(missing.unjudged.is_some());
    assert_eq!(bits(&missing), bits(&whole));
    assert_eq!(named(&missing.diagnosis), named(&whole.diagnosis));
    assert!(missing.diagnosis.found[0].held_out.is_none());
    let values =
        |d: &Diagnosed| -> Vec<u64> { d.diagnosis.found[0].parameters.iter().map(|p| p.value.to_bits()).collect() };
    assert_eq!(values(&missing), values(&whole));
}
