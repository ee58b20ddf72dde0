//! Whether errors are as large as they are said to be: how often a stated interval holds the truth.
//!
//! `cargo run --release -p gonio-tests --example coverage -- intervals [--seeds 200] [--scale 1] [--chosen PIXELS]`
//! `cargo run --release -p gonio-tests --example coverage -- chi-square CAPTURE... [--seeds 200]`
//!
//! `intervals` fits made captures: five photos of 64 x 48 pixels times `--scale`, of worlds whose films are rendered once with
//! so many samples that their own noise hardly counts, with new sensor noise and another seed of the fit each time. It counts how many
//! intervals of 1.96 standard errors hold the hidden number. `--chosen` compares so many pixels instead of all.
//!
//! `chi-square` evaluates captures at the numbers in their files, by 4, 16 and 64 samples and many seeds, and counts how many
//! intervals of 1.96 stated errors hold the mean of all.
//!
//! Of 200 trials of a true 95 % interval, 92 to 98 % hold in 19 of 20 runs (binomial).

#![allow(missing_docs, clippy::unwrap_used)]

mod chi_square;
mod intervals;

/// Half the width of a 95 % interval, in standard errors of a normal distribution.
const WITHIN: f64 = 1.96;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let what = arguments.next().unwrap_or_default();
    let (mut seeds, mut scale, mut chosen, mut captures) = (200, 1, None, Vec::new());
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().unwrap().parse::<u64>().unwrap();
        match argument.as_str() {
            "--seeds" => seeds = number(),
            "--scale" => scale = number() as u32,
            "--chosen" => chosen = Some(number()),
            _ => captures.push(argument),
        }
    }
    match what.as_str() {
        "intervals" => intervals::run(seeds, scale, chosen),
        "chi-square" => chi_square::run(&captures, seeds),
        other => panic!("\"{other}\": write intervals or chi-square"),
    }
}
