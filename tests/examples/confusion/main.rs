//! Who is taken for whom: hides every effect of the catalogue at two strengths, diagnoses, and writes what was named as
//! a table and a picture; how often something is named where nothing is hidden; and how strong an effect must be to be found.
//!
//! `cargo run --release -p gonio-tests --example confusion -- --out DIR [--seeds N] [--sweep STEPS] [--only NAME,...]
//! [--limit SECONDS]`
//!
//! `--seeds N` also diagnoses N captures without any effect. `--sweep STEPS` hides every effect up to STEPS times more, at
//! strengths about the one that is found half of the time. Each outcome is a line of `DIR/outcomes.jsonl`; those that are
//! there are not made again; what a diagnosis learnt is `DIR/evidence/EFFECT-STRENGTH-SEED.json`. A capture is made from its seed and is a file nowhere, unless `--keep` is given. `--limit`: no
//! capture is begun later than this, but what is known is written.

#![allow(missing_docs, clippy::unwrap_used)]

mod chart;
mod glyphs;
mod outcome;
mod picture;
mod staircase;
mod strengths;
mod table;
mod threshold;

use gonio::farm::Farm;
use gonio_diagnose::effects::CATALOGUE;
use gonio_tests::hidden::{STRENGTHS, unit};
use outcome::{Case, SWEPT};
use serde_json::Value;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

/// Seed of the captures with an effect; those without take the numbers from 100 on.
const SEED: u64 = 1;
/// Seeds of the sweeps: so many for each effect, from here on.
const SWEEPS: u64 = 1000;
const SEEDS_OF_SWEEP: u64 = 100;

fn main() {
    let mut out = PathBuf::from("confusion");
    let (mut nulls, mut sweep, mut keep, mut only, mut limit) = (0, 0, false, Vec::new(), f64::INFINITY);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--out" => out = arguments.next().unwrap().into(),
            "--seeds" => nulls = arguments.next().unwrap().parse().unwrap(),
            "--sweep" => sweep = arguments.next().unwrap().parse().unwrap(),
            "--only" => only = arguments.next().unwrap().split(',').map(str::to_owned).collect(),
            "--limit" => limit = arguments.next().unwrap().parse().unwrap(),
            "--keep" => keep = true,
            other => panic!("{other} is no option"),
        }
    }
    let evidence = out.join("evidence");
    std::fs::create_dir_all(&evidence).unwrap();
    let lines = out.join("outcomes.jsonl");
    let mut outcomes: Vec<Value> = std::fs::read_to_string(&lines)
        .unwrap_or_default()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let is_asked = |effect: &str| only.is_empty() || only.iter().any(|o| o == effect);
    let mut cases: Vec<Case> = Vec::new();
    for (label, at) in STRENGTHS {
        cases.extend(CATALOGUE.iter().map(|e| Case { effect: e.name, label, at, seed: SEED }));
    }
    cases.extend((0..nulls).map(|i| Case { effect: "none", label: "", at: 0.0, seed: 100 + i }));
    cases.retain(|case| is_asked(case.effect));
    let (farm, begin) = (Farm::embedded(0).unwrap(), Instant::now());
    let run = |case: Case, outcomes: &mut Vec<Value>| {
        if outcomes.iter().any(|o| case.is_of(o)) || begin.elapsed().as_secs_f64() > limit {
            return;
        }
        let outcome = case.run(&farm, &evidence, keep.then_some(&*out));
        println!("{outcome}");
        let mut file = std::fs::OpenOptions::new().create(true).append(true).open(&lines).unwrap();
        // In one piece: a line that a run which is ended leaves behind is whole.
        file.write_all(format!("{outcome}\n").as_bytes()).unwrap();
        outcomes.push(outcome);
    };
    for case in cases {
        run(case, &mut outcomes);
    }
    // One step of every effect before the next of any: what the limit cuts off, it cuts off evenly.
    for step in 0..sweep {
        for (number, effect) in CATALOGUE.iter().enumerate().filter(|(_, e)| is_asked(e.name)) {
            let [matrix, steps] = strengths::trials(&outcomes, effect.name);
            if steps.len() as u64 > step {
                continue;
            }
            if let Some(at) = staircase::next(&matrix, &steps, unit(effect.name).unwrap().most) {
                let seed = SWEEPS + SEEDS_OF_SWEEP * number as u64 + steps.len() as u64;
                run(Case { effect: effect.name, label: SWEPT, at, seed }, &mut outcomes);
            }
        }
    }
    std::fs::write(out.join("confusion.md"), table::page(&outcomes)).unwrap();
    picture::write(&outcomes, &out.join("confusion.png"));
    chart::write(&outcomes, &out.join("strengths.png"));
}
