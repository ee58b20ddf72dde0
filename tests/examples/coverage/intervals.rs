//! The stated intervals of fitted numbers against the numbers that were hidden.

use crate::WITHIN;
use gonio::farm::Farm;
use gonio_fit::{Evaluate, Options, fit};
use gonio_scene::{Capture, EvaluationRequest, Output};
use gonio_tests::hidden::Bench;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

/// Worlds that the trials share.
const WORLDS: u64 = 10;
/// Samples per pixel of their films: 64 times a fit's.
const SAMPLES: u32 = 4096;

/// Numbers of trials that hold, of all, and the sum of squared standardised errors.
#[derive(Default)]
struct Tally {
    held: u32,
    of: u32,
    squares: f64,
}

/// Fits `seeds` captures; prints how often each number's interval holds the truth.
pub fn run(seeds: u64, scale: u32, chosen: Option<u64>) {
    let farm = Farm::embedded(0).unwrap();
    let begin = Instant::now();
    let mut tallies: BTreeMap<String, Tally> = BTreeMap::new();
    let mut unfinished = 0;
    for world in 0..WORLDS.min(seeds) {
        let bench = Bench::new(500 + world, scale, SAMPLES);
        for trial in (world..seeds).step_by(WORLDS as usize) {
            let hidden = bench.capture(trial);
            let capture = Capture::read(&hidden.files).unwrap();
            let mut open = farm.open(&hidden.files).unwrap();
            if let Some(wanted) = chosen {
                let request = EvaluationRequest {
                    photos: (0..capture.photos.len()).collect(),
                    samples: 2,
                    output: Output::FirstHit,
                    ..EvaluationRequest::default()
                };
                let hits = open.evaluate(&request, &mut |_| ControlFlow::Continue(())).unwrap().films;
                open = open.with_design(&gonio_design::choose(&capture, &hits, trial, wanted)).unwrap();
            }
            let options = Options { seed: 10_000 + trial, ..Options::default() };
            let found = fit(&capture, &mut open, &options, &mut |_| ControlFlow::Continue(())).unwrap();
            unfinished += u32::from(!found.converged);
            let truth = hidden.truth.numbers();
            for p in &found.parameters {
                // A gray colour is one number: its first channel is all of it.
                let hidden = truth.get(&p.name).or_else(|| truth.get(&format!("{}.r", p.name)));
                let (Some((true_value, _)), Some(error)) = (hidden, p.standard_error) else { continue };
                let off = (p.value - true_value) / error;
                let tally = tallies.entry(p.name.clone()).or_default();
                tally.held += u32::from(off.abs() < WITHIN);
                tally.of += 1;
                tally.squares += off * off;
            }
        }
        eprintln!("world {} of {WORLDS}: {:.0} s", world + 1, begin.elapsed().as_secs_f64());
    }
    println!(
        "number: intervals that hold the truth, root mean square of error / stated error ({unfinished} not converged)"
    );
    let mut all = Tally::default();
    for (name, t) in &tallies {
        println!(
            "{name}: {:.1} %, {:.3}",
            100.0 * f64::from(t.held) / f64::from(t.of),
            (t.squares / f64::from(t.of)).sqrt()
        );
        all.held += t.held;
        all.of += t.of;
    }
    println!("all: {:.1} % of {}", 100.0 * f64::from(all.held) / f64::from(all.of.max(1)), all.of);
}
