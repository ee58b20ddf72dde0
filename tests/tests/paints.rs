//! Measured car and spray paints (Cornell University, Program of Computer Graphics), which are no part of this project:
//! from the folder that `GONIO_REAL` names, or from `../shared/real` beside the checkout; skipped where there is none.
//!
//! The rule of the split: incidence at 20, 40, 60 and 80 degrees is fitted to, at 10, 30, 50 and 70 degrees held out. The
//! measure: the root of the held-out mean of (asinh(fit / FLOOR) - asinh(measured / FLOOR))^2 over samples and channels: the
//! difference of logarithms where values are far above FLOOR, and of values over FLOOR far below. It is what the fit
//! minimises, too.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio::farm::Farm;
use gonio_fit::{FitResult, Options, fit};
use gonio_scene::Capture;
use gonio_scene::files::MemoryFiles;
use gonio_tests::hidden::{diagnosed, named};
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

/// The standard deviation relative to a value.
const RELATIVE: f64 = 0.05;
/// Where ratios turn into differences, 1/sr.
const FLOOR: f64 = 0.002;

const PLASTIC: &str = "model = \"plastic\"\nbase_color = [0.3, 0.3, 0.3]\nroughness = 0.4\nior = 1.5\n";
const FREE: &str = "\"material.paint.base_color\", \"material.paint.roughness\", \"material.paint.ior\"";

fn folder() -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/real");
    let folder = std::env::var_os("GONIO_REAL").map_or_else(beside, PathBuf::from).join("paint-brdf");
    folder.is_dir().then_some(folder)
}

/// The paints' names and files; none, with a word about it, where they are not there.
fn paints() -> Vec<(&'static str, String)> {
    let Some(folder) = folder() else {
        println!("skipped: no paint-brdf in GONIO_REAL or ../shared/real");
        return Vec::new();
    };
    let read = |name| (name, std::fs::read_to_string(folder.join(format!("{name}.brdf"))).unwrap());
    ["acryl_blue", "cayman", "garnet_red", "krylon_blue", "mystique"].map(read).into()
}

/// A paint's samples as reflectance files, one per angle of incidence. Azimuths are as a capture has them: the highlights
/// lie at 180 degrees.
fn files(text: &str) -> Vec<(u32, String)> {
    let plain: String = text.lines().map(|line| line.split('#').next().unwrap_or("").to_owned() + "\n").collect();
    let mut numbers = plain.split_whitespace().map(|word| word.parse::<f64>().unwrap());
    let wavelengths: Vec<f64> = (0..numbers.next().unwrap() as usize).map(|_| numbers.next().unwrap()).collect();
    let values: Vec<f64> = numbers.collect();
    let mut files: Vec<(u32, String)> = Vec::new();
    for row in values.chunks_exact(4 + wavelengths.len()) {
        let degrees = row[0].to_degrees().round() as u32;
        let file = match files.iter_mut().find(|f| f.0 == degrees) {
            Some(file) => file,
            None => {
                let names: Vec<String> = wavelengths.iter().map(f64::to_string).collect();
                files.push((degrees, format!("theta_i,phi_i,theta_o,phi_o,{}\n", names.join(","))));
                files.last_mut().unwrap()
            }
        };
        write!(file.1, "{},{},{},{}", row[0], row[1], row[2], row[3]).unwrap();
        row[4..].iter().for_each(|v| write!(file.1, ",{v}").unwrap());
        file.1.push('\n');
    }
    files
}

/// A capture of a paint's samples, even angles over ten degrees to be fitted to.
fn capture(text: &str, keys: &str, free: &str) -> MemoryFiles {
    let mut toml = format!(
        "format = 1\nname = \"paint\"\n[[material]]\nname = \"paint\"\n{PLASTIC}{keys}\n[fit]\nparameters = [{FREE}{free}]\n"
    );
    let mut memory = MemoryFiles::default();
    for (degrees, csv) in files(text) {
        let role = if degrees % 20 == 0 { "fit" } else { "held-out" };
        write!(
            toml,
            "[[reflectance]]\nfile = \"{degrees}.csv\"\nmaterial = \"paint\"\nrole = \"{role}\"\n\
             relative_noise = {RELATIVE}\nnoise = {}\n",
            RELATIVE * FLOOR
        )
        .unwrap();
        memory.0.insert(format!("{degrees}.csv"), Arc::from(csv.as_bytes()));
    }
    memory.0.insert("capture.toml".to_owned(), Arc::from(toml.as_bytes()));
    memory
}

fn run(farm: &Farm, text: &str, keys: &str, free: &str) -> FitResult {
    let memory = capture(text, keys, free);
    let capture = Capture::read(&memory).unwrap();
    let mut open = farm.open(&memory).unwrap();
    let options = Options { min_samples: 2, max_samples: 2, ..Options::default() };
    fit(&capture, &mut open, &options, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn error(result: &FitResult) -> f64 {
    RELATIVE * result.held_out.unwrap().reduced_chi_square.sqrt()
}

#[test]
fn a_coat_or_a_lobe_pays_on_layered_paints_only() {
    let farm = Farm::embedded(0).unwrap();
    for (name, text) in paints() {
        let text = text.as_str();
        let tell = |case: &str, result: &FitResult| {
            let values: Vec<String> =
                result.parameters.iter().map(|p| format!("{} {:.4}", &p.name[15..], p.value)).collect();
            println!(
                "{name} {case}: held out {:.4}, fit {:.4}, converged {} after {}; {}",
                error(result),
                RELATIVE * result.fit.reduced_chi_square.sqrt(),
                result.converged,
                result.iterations,
                values.join(", ")
            );
        };
        let plain = run(&farm, text, "", "");
        tell("plastic", &plain);
        let lobe = "second_lobe_weight = 0.3\nsecond_lobe_roughness = 0.2";
        let lobe =
            run(&farm, text, lobe, ", \"material.paint.second_lobe_weight\", \"material.paint.second_lobe_roughness\"");
        tell("second lobe", &lobe);
        let coat = "clearcoat_factor = 0.5\nclearcoat_roughness = 0.15";
        let coat =
            run(&farm, text, coat, ", \"material.paint.clearcoat_factor\", \"material.paint.clearcoat_roughness\"");
        tell("clear coat", &coat);
        let gain = 1.0 - error(&lobe).min(error(&coat)) / error(&plain);
        println!("{name}: the better of the two lowers the held-out error by {:.1} %", 100.0 * gain);
        match name {
            "cayman" | "mystique" => assert!(gain >= 0.1, "{name}: {gain}"),
            "garnet_red" | "krylon_blue" => assert!(gain <= 0.03, "{name}: {gain}"),
            _ => {}
        }
    }
}

/// Both are layered: flakes under a coat. Which of the two names their surplus gets is not asked.
#[test]
fn a_coat_or_a_lobe_is_named_on_layered_paints_only() {
    let farm = Farm::embedded(0).unwrap();
    for (name, text) in paints() {
        let memory = capture(&text, "", "");
        let found = diagnosed(&farm, &memory, &gonio_diagnose::Options::default()).unwrap().diagnosis;
        let held_out = found.found.first().and_then(|f| f.held_out);
        println!("{name}: {:?} {:?}, {:.1} s; {:?}", found.verdict, named(&found), found.seconds, found.unexplained);
        for c in &found.candidates {
            println!(
                "    {} {:?} {:?}: {}",
                c.effect,
                c.gain,
                c.expected_change,
                c.refused_because.as_deref().unwrap_or("found")
            );
        }
        let gain = held_out.map_or(0.0, |h| 1.0 - (h.reduced_chi_square_after / h.reduced_chi_square_before).sqrt());
        println!("{name}: {held_out:?}, error lower by {:.1} %", 100.0 * gain);
        let layers = named(&found).iter().flat_map(|s| s.iter()).any(|e| e == "second-lobe" || e == "clear-coat");
        match name {
            "cayman" | "mystique" => assert!(layers && gain >= 0.1, "{name}: {gain}"),
            "garnet_red" | "krylon_blue" => assert!(!layers, "{name}"),
            _ => {}
        }
    }
}
