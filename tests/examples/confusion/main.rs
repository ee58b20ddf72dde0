//! Who is taken for whom: hides every effect of the catalogue at two strengths, diagnoses, and writes what was named as
//! a table and a picture; and how often something is named where nothing is hidden.
//!
//! `cargo run --release -p gonio-tests --example confusion -- --out DIR [--seeds N] [--only NAME,...] [--limit SECONDS]`
//!
//! `--seeds N` also diagnoses N captures without any effect. Each outcome is a line of `DIR/outcomes.jsonl`; those that
//! are there are not made again. A capture is made from its seed and is a file nowhere, unless `--keep` is given.

#![allow(missing_docs, clippy::unwrap_used)]

mod picture;
mod table;

use gonio::farm::Farm;
use gonio_diagnose::Options;
use gonio_diagnose::effects::CATALOGUE;
use gonio_tests::hidden::{STRENGTHS, diagnosed, hide, named};
use serde_json::{Value, json};
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

/// Samples per pixel of the hidden captures' films.
const SAMPLES: u32 = 512;
/// Seed of the captures with an effect; those without take the numbers from 100 on.
const SEED: u64 = 1;

fn main() {
    let mut out = PathBuf::from("confusion");
    let (mut nulls, mut keep, mut only, mut limit) = (0, false, Vec::new(), f64::INFINITY);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--out" => out = arguments.next().unwrap().into(),
            "--seeds" => nulls = arguments.next().unwrap().parse().unwrap(),
            "--only" => only = arguments.next().unwrap().split(',').map(str::to_owned).collect(),
            "--limit" => limit = arguments.next().unwrap().parse().unwrap(),
            "--keep" => keep = true,
            other => panic!("{other} is no option"),
        }
    }
    std::fs::create_dir_all(&out).unwrap();
    let lines = out.join("outcomes.jsonl");
    let mut outcomes: Vec<Value> = std::fs::read_to_string(&lines)
        .unwrap_or_default()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let mut cases: Vec<(&str, &str, f64, u64)> = Vec::new();
    for (label, strength) in STRENGTHS {
        cases.extend(CATALOGUE.iter().map(|e| (e.name, label, strength, SEED)));
    }
    cases.extend((0..nulls).map(|i| ("none", "", 0.0, 100 + i)));
    cases.retain(|(effect, ..)| only.is_empty() || only.iter().any(|o| o == effect));
    let (farm, begin) = (Farm::embedded(0).unwrap(), Instant::now());
    for (effect, label, strength, seed) in cases {
        let known = |o: &Value| o["effect"] == effect && o["strength"] == label && o["seed"] == seed;
        if outcomes.iter().any(known) || begin.elapsed().as_secs_f64() > limit {
            continue;
        }
        let effects: Vec<_> = (effect != "none").then_some((effect, strength)).into_iter().collect();
        let hidden = hide(&effects, seed, SAMPLES);
        if keep {
            hidden.save(&out.join(format!("{effect}-{label}-{seed}")));
        }
        let outcome = match diagnosed(&farm, &hidden.files, &Options::default()) {
            Ok(done) => {
                let d = &done.diagnosis;
                let held_out = d.found.first().and_then(|f| f.held_out);
                let planted = d.candidates.iter().find(|c| c.effect == effect);
                json!({
                    "effect": effect, "strength": label, "seed": seed,
                    "verdict": d.verdict, "named": named(d),
                    "gain": held_out.map(|h| h.log_density_gain),
                    "chi_before": d.base.fit.reduced_chi_square, "chi_after": d.last.fit.reduced_chi_square,
                    "refused": planted.and_then(|c| c.refused_because.clone()),
                    "left": d.unexplained.as_ref().map(|u| u.covariate.clone()), "seconds": d.seconds,
                })
            }
            Err(error) => {
                json!({ "effect": effect, "strength": label, "seed": seed, "verdict": "failed", "named": [], "refused": error.to_string() })
            }
        };
        println!("{outcome}");
        let mut file = std::fs::OpenOptions::new().create(true).append(true).open(&lines).unwrap();
        writeln!(file, "{outcome}").unwrap();
        outcomes.push(outcome);
    }
    std::fs::write(out.join("confusion.md"), table::page(&outcomes)).unwrap();
    picture::write(&outcomes, &out.join("confusion.png"));
}
