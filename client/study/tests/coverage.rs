//! Simulated observers: how often the intervals of 95 % hold the truth.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_study::{Counts, Detection, Estimate, LEVELS, Options, Rating, Ratings, Roc, Summary, Truth, plot};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};
use std::f64::consts::PI;

/// People who differ: means and deviations over them.
struct People {
    d_prime: (f64, f64),
    bias: f64,
    /// Deviation of the evidence of synthetic images; real ones have 1.
    spread: f64,
}

const CRITERIA: [f64; LEVELS - 1] = [-0.5, 0.2, 0.7, 1.4];

fn normal(random: &mut Xoshiro256PlusPlus) -> f64 {
    let mut unit = || ((random.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
    let (a, b) = (unit(), unit());
    (-2.0 * libm::log(a)).sqrt() * libm::cos(2.0 * PI * b)
}

/// A study of `observers`, each with `trials` images of either kind.
fn study(people: &People, observers: usize, trials: usize, random: &mut Xoshiro256PlusPlus) -> Ratings {
    let mut rows = Vec::new();
    for observer in 0..observers {
        let mean = people.d_prime.0 + people.d_prime.1 * normal(random);
        let bias = people.bias * normal(random);
        for (truth, mean, spread) in [(Truth::Real, 0.0, 1.0), (Truth::Synthetic, mean, people.spread)] {
            for image in 0..trials {
                let evidence = mean + spread * normal(random);
                let rating = 1 + CRITERIA.iter().filter(|&&c| evidence > c + bias).count() as u8;
                let image = format!("{}{image}", truth.word());
                rows.push(Rating { observer: format!("{observer}"), image, truth, rating });
            }
        }
    }
    Ratings { rows }
}

fn summary(ratings: &Ratings, resamples: u32) -> Summary {
    Summary::new("simulated", ratings, &Options { criterion: 4, resamples, seed: 1 }).unwrap()
}

fn holds(estimate: &Estimate, truth: f64) -> bool {
    (estimate.low..=estimate.high).contains(&truth)
}

/// Shares of 1000 studies whose intervals hold the truth of d', d_a and slope. The truth is what the same
/// estimators say of very many observers, or, for d', of these trials: their small known bias is not the intervals' to cover.
fn coverage(people: &People, observers: usize, trials: usize, seed: u64) -> [f64; 3] {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let large = study(people, 20_000, trials, &mut random);
    let (mut all, mut d_prime) = (Counts::default(), 0.0);
    for rows in large.rows.chunks(2 * trials) {
        let mut own = Counts::default();
        for row in rows {
            let cells = if row.truth == Truth::Real { &mut own.real } else { &mut own.synthetic };
            cells[usize::from(row.rating) - 1] += 1;
        }
        all.add(&own);
        d_prime += own.at(4).d_prime() / 20_000.0;
    }
    let truth = Roc::fit(&all).unwrap();
    let mut held = [0.0; 3];
    for _ in 0..1000 {
        let found = summary(&study(people, observers, trials, &mut random), 200);
        let (d_a, slope) = (found.d_a.unwrap(), found.slope.unwrap());
        for (share, holds) in
            held.iter_mut().zip([holds(&found.d_prime, d_prime), holds(&d_a, truth.d_a()), holds(&slope, truth.slope)])
        {
            *share += if holds { 1e-3 } else { 0.0 };
        }
    }
    println!("{observers} observers, {trials} trials: d' {d_prime:.3}, held {held:.3?}");
    held
}

#[test]
fn intervals_of_95_percent_hold_the_truth_as_often() {
    let alike = People { d_prime: (1.0, 0.0), bias: 0.0, spread: 1.0 };
    let apart = People { d_prime: (1.2, 0.5), bias: 0.3, spread: 1.25 };
    for (people, observers, trials) in [(&alike, 6, 20), (&apart, 10, 30), (&apart, 20, 24)] {
        for share in coverage(people, observers, trials, 20) {
            assert!((0.92..=0.98).contains(&share), "{observers} observers, {trials} trials: {share}");
        }
    }
}

#[test]
fn millers_error_is_the_spread_of_one_observer_tested_often() {
    let alike = People { d_prime: (1.0, 0.0), bias: 0.0, spread: 1.0 };
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let found = summary(&study(&alike, 4000, 20, &mut random), 2);
    let n = found.observers.len() as f64;
    let mean = found.observers.iter().map(|row| row.d_prime).sum::<f64>() / n;
    let spread = found.observers.iter().map(|row| (row.d_prime - mean).powi(2)).sum::<f64>() / (n - 1.0);
    // At the true rates, not at those of one observer: Phi(-0.7) and Phi(0.3).
    let exact = gonio_study::miller_variance(0.241_96, 20) + gonio_study::miller_variance(0.617_91, 20);
    assert!((spread / exact - 1.0).abs() < 0.07, "{spread} {exact}");
}

#[test]
fn a_summary_lists_observers_and_images_and_draws_itself() {
    let people = People { d_prime: (1.2, 0.3), bias: 0.2, spread: 1.1 };
    let found = summary(&study(&people, 5, 20, &mut Xoshiro256PlusPlus::seed_from_u64(5)), 100);
    assert_eq!((found.observers.len(), found.images.len()), (5, 40));
    assert!(found.images.windows(2).all(|pair| pair[0].d_prime >= pair[1].d_prime));
    let counted: u32 = found.observers.iter().map(|row| row.counts.hits).sum();
    let Detection { hits, .. } = found.counts.at(4);
    assert_eq!(counted, hits);
    let svg = plot(&found);
    assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n") && !svg.contains("NaN"));
}

#[test]
fn one_observer_or_one_kind_is_refused() {
    let row = |observer: &str, truth, rating| Rating { observer: observer.into(), image: "x".into(), truth, rating };
    let options = Options { criterion: 4, resamples: 10, seed: 0 };
    let refused = |rows| Summary::new("r.csv", &Ratings { rows }, &options).unwrap_err().to_string();
    assert!(refused(vec![]).starts_with("r.csv: observer: holds no answer"));
    let one = vec![row("a", Truth::Real, 1), row("a", Truth::Synthetic, 5)];
    assert!(refused(one.clone()).contains("one observer only, \"a\""));
    let kind = [one, vec![row("b", Truth::Real, 1)]].concat();
    assert!(refused(kind).contains("\"b\" rated no synthetic image"));
}
