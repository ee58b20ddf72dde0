//! Several causes at once, and files that are wrong: makes captures from seeds, diagnoses them, and writes what was named.
//!
//! `cargo run --release -p gonio-tests --example causes -- pairs|triples|suspects|noise|nothing --out DIR [--count N] [--from SEED]
//! [--limit SECONDS] [--keep]`
//!
//! `pairs` and `triples` hide two or three effects of the catalogue at strengths from weak to moderate; `suspects` states a number of the file
//! wrongly; `noise` says that the sensor is half as noisy as it is; `nothing` hides nothing. Each outcome is a line of `DIR/KIND.jsonl`, and what the
//! diagnosis learnt is `DIR/evidence/KIND-SEED.json`; what is there is not made again. `--limit`: no capture is begun later. `--keep` writes the captures' folders, too.

#![allow(missing_docs, clippy::unwrap_used)]

mod case;

use case::{Case, Kind};
use gonio::farm::Farm;
use serde_json::Value;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let kind = Kind::of(&arguments.next().unwrap_or_default());
    let (mut out, mut count, mut from, mut limit, mut keep) = (PathBuf::from("causes"), 20, 0, f64::INFINITY, false);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap();
        match argument.as_str() {
            "--out" => out = value().into(),
            "--count" => count = value().parse().unwrap(),
            "--from" => from = value().parse().unwrap(),
            "--keep" => keep = true,
            "--limit" => limit = value().parse().unwrap(),
            other => panic!("{other} is no option"),
        }
    }
    let evidence = out.join("evidence");
    std::fs::create_dir_all(&evidence).unwrap();
    let lines = out.join(format!("{}.jsonl", kind.name()));
    let text = std::fs::read_to_string(&lines).unwrap_or_default();
    let mut outcomes: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (farm, begin) = (Farm::embedded(0).unwrap(), Instant::now());
    for seed in from..from + count {
        if outcomes.iter().any(|o| o["seed"] == seed) || begin.elapsed().as_secs_f64() > limit {
            continue;
        }
        let outcome = Case { kind, seed }.run(&farm, &evidence, keep.then_some(&*out));
        println!("{outcome}");
        let mut file = std::fs::OpenOptions::new().create(true).append(true).open(&lines).unwrap();
        file.write_all(format!("{outcome}\n").as_bytes()).unwrap();
        outcomes.push(outcome);
    }
    let share = |key: &str| outcomes.iter().filter(|o| o[key] == true).count();
    println!(
        "{} captures: all hidden causes named in {}, nothing else named in {}",
        outcomes.len(),
        share("all"),
        share("clean")
    );
}
