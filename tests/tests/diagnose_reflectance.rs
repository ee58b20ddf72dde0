//! What is hidden in measured reflectance is named, and nothing else: samples of a plastic, or of two, by a formula that
//! shares no code with the renderer, with noise, one file per angle of incidence.

#![allow(clippy::unwrap_used)] // a test fails by panicking

mod planted;

use gonio::farm::Farm;
use gonio_diagnose::effects::all;
use gonio_diagnose::{Diagnosed, Options, Verdict};
use gonio_scene::files::MemoryFiles;
use gonio_tests::hidden::{Hidden, diagnosed, hide, named};
use gonio_tests::noise::gaussian;
use planted::Plastic;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::sync::Arc;

const PLASTIC: Plastic = Plastic { base_color: [0.5, 0.25, 0.05], roughness: 0.5, ior: 1.5 };
/// Weight and roughness of the hidden lobe.
const LOBE: (f64, f64) = (0.35, 0.25);
/// Standard deviation relative to the value, stated and true.
const NOISE: f64 = 0.03;
/// Angles of incidence in degrees, fitted to where they are even in tens.
const INCIDENCE: [u32; 7] = [10, 20, 30, 40, 50, 60, 70];

/// Samples of a plastic at one angle of incidence, of which the part `weight` is the hidden lobe's.
fn csv(plastic: &Plastic, degrees: u32, weight: f64) -> String {
    let (first, second) = (plastic.prepare(), Plastic { roughness: LOBE.1, ..*plastic }.prepare());
    let mut text = "theta_i,phi_i,theta_o,phi_o,r,g,b\n".to_owned();
    for o in 0..15 {
        for p in 0..13 {
            let sample = [
                f64::from(degrees).to_radians(),
                0.0,
                0.05 + 0.1 * f64::from(o),
                std::f64::consts::PI * f64::from(p) / 12.0,
            ];
            write!(text, "{},{},{},{}", sample[0], sample[1], sample[2], sample[3]).unwrap();
            let (first, second) = (first.brdf(sample), second.brdf(sample));
            for c in 0..3 {
                let counter = u64::from(((degrees * 15 + o) * 13 + p) * 3 + c);
                let value = (1.0 - weight) * first[c as usize] + weight * second[c as usize];
                write!(text, ",{}", value * (1.0 + NOISE * gaussian(counter))).unwrap();
            }
            text.push('\n');
        }
    }
    text
}

fn held_out(degrees: u32) -> bool {
    degrees / 10 % 2 == 1
}

fn capture(weight: f64) -> MemoryFiles {
    let mut toml = "format = 1\nname = \"planted\"\n[[material]]\nname = \"paint\"\nmodel = \"plastic\"\n\
         base_color = [0.4, 0.4, 0.4]\nroughness = 0.6\nior = 1.4\n\
         [fit]\nparameters = [\"material.paint.base_color\", \"material.paint.roughness\", \"material.paint.ior\"]\n"
        .to_owned();
    let mut files = MemoryFiles::default();
    for degrees in INCIDENCE {
        let role = if held_out(degrees) { "held-out" } else { "fit" };
        write!(toml, "[[reflectance]]\nfile = \"{degrees}.csv\"\nmaterial = \"paint\"\nrole = \"{role}\"\nrelative_noise = {NOISE}\nnoise = 1e-4\n").unwrap();
        files.0.insert(format!("{degrees}.csv"), Arc::from(csv(&PLASTIC, degrees, weight).as_bytes()));
    }
    files.0.insert("capture.toml".to_owned(), Arc::from(toml.as_bytes()));
    files
}

fn diagnose(files: &MemoryFiles) -> Diagnosed {
    diagnose_with(files, &Options::default())
}

fn diagnose_with(files: &MemoryFiles, options: &Options) -> Diagnosed {
    let farm = Farm::embedded(0).unwrap();
    let done = diagnosed(&farm, files, options).unwrap();
    let d = &done.diagnosis;
    let (before, after) = (d.base.fit.reduced_chi_square, d.last.fit.reduced_chi_square);
    println!("{:?} {:?}, chi-square {before:.3} -> {after:.3}, {:.1} s", d.verdict, named(d), d.seconds);
    println!("{:?} {:?}", d.found, d.unexplained);
    done
}

#[test]
fn nothing_is_named_where_nothing_is_hidden() {
    let found = diagnose(&capture(0.0)).diagnosis;
    assert_eq!(found.verdict, Verdict::None, "{:?} {:?}", named(&found), found.unexplained);
}

#[test]
fn a_hidden_lobe_is_named_and_measured() {
    let done = diagnose(&capture(LOBE.0));
    let found = &done.diagnosis;
    assert_eq!(found.verdict, Verdict::Named);
    assert_eq!(named(found)[0][0], "second-lobe");
    let held_out = found.found[0].held_out.unwrap();
    assert!(held_out.reduced_chi_square_after < 1.2 && held_out.reduced_chi_square_before > 1.5);
    for (key, hidden, bound) in [("weight", LOBE.0, 0.05), ("roughness", LOBE.1, 0.02)] {
        let name = format!("material.paint.second_lobe_{key}");
        let value = found.found[0].parameters.iter().find(|p| p.name == name).unwrap().value;
        assert!((value - hidden).abs() < bound, "{name}: {value} instead of {hidden}");
    }
    // Nothing but the material can be at fault.
    let acted = found.candidates.iter().filter(|c| c.score.is_some()).map(|c| c.effect.as_str());
    let acted: BTreeSet<_> = acted.collect();
    let expected = ["anisotropy", "clear-coat", "diffuse-roughness", "metallic", "second-lobe", "sheen"];
    assert!(acted.iter().eq(expected.iter()), "{acted:?}");
    assert_eq!(done.capture.reflectance.len(), INCIDENCE.len());
}

/// Files that are held out are not even opened before the selection has ended.
#[test]
fn held_out_files_are_not_looked_at() {
    let mut files = capture(LOBE.0);
    let whole = diagnose(&files);
    for degrees in INCIDENCE.into_iter().filter(|d| held_out(*d)) {
        let text = csv(&PLASTIC, degrees, LOBE.0);
        let sealed: String = text
            .lines()
            .enumerate()
            .map(|(i, line)| match i {
                0 => format!("{line}\n"),
                _ => line.split(',').take(4).chain(["none"; 3]).collect::<Vec<_>>().join(",") + "\n",
            })
            .collect();
        files.0.insert(format!("{degrees}.csv"), Arc::from(sealed.as_bytes()));
    }
    let sealed = diagnose(&files);
    assert!(sealed.unjudged.is_some());
    let values =
        |done: &Diagnosed| -> Vec<u64> { done.diagnosis.last.parameters.iter().map(|p| p.value.to_bits()).collect() };
    assert_eq!(values(&sealed), values(&whole));
    assert_eq!(named(&sealed.diagnosis), named(&whole.diagnosis));
}

/// Beside photos, files of reflectance neither hide an effect of the camera nor are taken for one.
#[test]
fn photos_and_files_are_diagnosed_together() {
    let Hidden { mut files, truth } = hide(&[("vignetting", 1.0)], 1, 64);
    let numbers = truth.numbers();
    let number = |key: &str| numbers[&format!("material.part.{key}")].0;
    let base_color = ["r", "g", "b"].map(|c| number(&format!("base_color.{c}")));
    let plastic = Plastic { base_color, roughness: number("roughness"), ior: number("ior") };
    let mut toml = String::from_utf8(files.0["capture.toml"].to_vec()).unwrap();
    for degrees in [20, 60] {
        write!(toml, "\n[[reflectance]]\nfile = \"{degrees}.csv\"\nmaterial = \"part\"\nrelative_noise = {NOISE}\n")
            .unwrap();
        files.0.insert(format!("{degrees}.csv"), Arc::from(csv(&plastic, degrees, 0.0).as_bytes()));
    }
    files.0.insert("capture.toml".to_owned(), Arc::from(toml.as_bytes()));
    let considered = ["vignetting", "second-lobe", "black-level"];
    let without = all().map(|e| e.name.to_owned()).filter(|e| !considered.contains(&e.as_str())).collect();
    let done = diagnose_with(&files, &Options { without, ..Options::default() });
    assert_eq!(named(&done.diagnosis), [["vignetting".to_owned()]]);
    assert_eq!(done.capture.reflectance.len(), 2);
    assert_eq!(done.before.iter().filter(|seen| !seen.pairs.is_empty()).count(), 2);
}
