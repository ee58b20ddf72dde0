//! A study's result: group, observers, images.

use crate::detection::corrected;
use crate::interval::Estimate;
use crate::normal::z;
use crate::{Counts, Detection, Ratings, Roc, StudyError, Truth};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};
use serde::Serialize;
use std::collections::BTreeMap;

/// How to summarise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// The lowest rating that counts as "synthetic" where one decision is wanted, 2..=5.
    pub criterion: u8,
    /// Resampled studies, at least 2.
    pub resamples: u32,
    /// Seed of the resampling.
    pub seed: u64,
}

/// One observer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObserverRow {
    /// The name.
    pub observer: String,
    /// Counts at the criterion.
    pub counts: Detection,
    /// d' at the criterion.
    pub d_prime: f64,
    /// Its standard error within this observer, by Miller (1996).
    pub error: f64,
    /// The criterion's place c.
    pub criterion: f64,
}

/// One image over all observers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ImageRow {
    /// The name.
    pub image: String,
    /// What it is.
    pub truth: Truth,
    /// Answers.
    pub answers: u32,
    /// Mean rating, 1..=5.
    pub mean: f64,
    /// Share called synthetic, 0..=1.
    pub called_synthetic: f64,
    /// d' of this image against all images of the other kind: how well it is told for what it is.
    pub d_prime: f64,
}

/// What a study found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Mean of the observers' d' at the criterion.
    pub d_prime: Estimate,
    /// Standard error of that mean if all observers were alike and only their few trials mattered (Miller 1996).
    pub within_error: f64,
    /// d_a of the pooled ratings; absent where fewer than three levels were used.
    pub d_a: Option<Estimate>,
    /// Slope of their zROC.
    pub slope: Option<Estimate>,
    /// Area below their ROC: the share right in a choice between a real and a synthetic image.
    pub area: Option<f64>,
    /// The fitted line.
    pub roc: Option<Roc>,
    /// All ratings.
    pub counts: Counts,
    /// By name.
    pub observers: Vec<ObserverRow>,
    /// By how well they are told, the most obvious first.
    pub images: Vec<ImageRow>,
}

impl Summary {
    /// Summarises `ratings`, which came from `file`.
    ///
    /// # Errors
    /// Fewer than two observers, or one who rated images of one kind only.
    pub fn new(file: &str, ratings: &Ratings, options: &Options) -> Result<Self, StudyError> {
        let mut each: BTreeMap<&str, Counts> = BTreeMap::new();
        for row in &ratings.rows {
            let counts = each.entry(&row.observer).or_default();
            let cells = if row.truth == Truth::Real { &mut counts.real } else { &mut counts.synthetic };
            cells[usize::from(row.rating) - 1] += 1;
        }
        if each.len() < 2 {
            let problem = match each.keys().next() {
                None => "holds no answer".to_owned(),
                Some(name) => format!("has answers of one observer only, \"{name}\""),
            };
            let mend = "ask at least two people: intervals come from how people differ";
            return Err(StudyError::new(file, problem, mend).of("observer"));
        }
        for (name, counts) in &each {
            let missing = [(counts.at(2).real, Truth::Real), (counts.at(2).synthetic, Truth::Synthetic)];
            if let Some((_, truth)) = missing.into_iter().find(|(shown, _)| *shown == 0) {
                let problem = format!("\"{name}\" rated no {} image", truth.word());
                return Err(
                    StudyError::new(file, problem, "show both kinds to everyone, or leave them out").of("observer")
                );
            }
        }
        let counts: Vec<Counts> = each.values().copied().collect();
        let observers: Vec<_> = each.iter().map(|(name, counts)| observer(name, counts, options.criterion)).collect();
        let all = pooled(counts.iter());
        let roc = Roc::fit(&all);
        let spread = Resamples::new(&counts, &observers, options);
        let number = observers.len();
        let mean = observers.iter().map(|row| row.d_prime).sum::<f64>() / number as f64;
        let within = observers.iter().map(|row| row.error * row.error).sum::<f64>().sqrt() / number as f64;
        let of = |value: f64, values: &[f64]| Estimate::from_resamples(value, values, number);
        // A study whose resamples hardly ever determine a line does not determine one.
        let line = roc.filter(|_| spread.d_a.len() * 2 > spread.d_prime.len());
        Ok(Self {
            d_prime: of(mean, &spread.d_prime),
            within_error: within,
            d_a: line.map(|roc| of(roc.d_a(), &spread.d_a)),
            slope: line.map(|roc| of(libm::log(roc.slope), &spread.log_slope).exponential()),
            area: line.map(|roc| roc.area()),
            roc: line,
            counts: all,
            images: images(ratings, &all, options.criterion),
            observers,
        })
    }
}

fn observer(name: &str, counts: &Counts, level: u8) -> ObserverRow {
    let counts = counts.at(level);
    ObserverRow {
        observer: name.to_owned(),
        counts,
        d_prime: counts.d_prime(),
        error: counts.variance().sqrt(),
        criterion: counts.criterion(),
    }
}

fn pooled<'a>(each: impl Iterator<Item = &'a Counts>) -> Counts {
    each.fold(Counts::default(), |mut sum, counts| {
        sum.add(counts);
        sum
    })
}

/// Statistics of studies whose observers are drawn from this one's, with replacement.
struct Resamples {
    d_prime: Vec<f64>,
    d_a: Vec<f64>,
    log_slope: Vec<f64>,
}

impl Resamples {
    fn new(counts: &[Counts], observers: &[ObserverRow], options: &Options) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(options.seed);
        let number = counts.len();
        let mut spread = Self { d_prime: Vec::new(), d_a: Vec::new(), log_slope: Vec::new() };
        for _ in 0..options.resamples {
            // The bias of a remainder of 2^64 is far below anything that is counted here.
            let drawn: Vec<usize> = (0..number).map(|_| (random.next_u64() % number as u64) as usize).collect();
            spread.d_prime.push(drawn.iter().map(|&i| observers[i].d_prime).sum::<f64>() / number as f64);
            if let Some(roc) = Roc::fit(&pooled(drawn.iter().map(|&i| &counts[i]))) {
                spread.d_a.push(roc.d_a());
                spread.log_slope.push(libm::log(roc.slope));
            }
        }
        spread
    }
}

fn images(ratings: &Ratings, all: &Counts, level: u8) -> Vec<ImageRow> {
    let group = all.at(level);
    let mut each: BTreeMap<&str, (Truth, Vec<u8>)> = BTreeMap::new();
    for row in &ratings.rows {
        each.entry(&row.image).or_insert((row.truth, Vec::new())).1.push(row.rating);
    }
    let mut rows: Vec<_> = each
        .into_iter()
        .map(|(image, (truth, given))| {
            let answers = given.len() as u32;
            let called = given.iter().filter(|&&rating| rating >= level).count() as u32;
            let own = z(corrected(called, answers));
            let d_prime = match truth {
                Truth::Synthetic => own - z(corrected(group.false_alarms, group.real)),
                Truth::Real => z(corrected(group.hits, group.synthetic)) - own,
            };
            let mean = given.iter().map(|&rating| f64::from(rating)).sum::<f64>() / f64::from(answers);
            let called_synthetic = f64::from(called) / f64::from(answers);
            ImageRow { image: image.to_owned(), truth, answers, mean, called_synthetic, d_prime }
        })
        .collect();
    rows.sort_by(|a, b| b.d_prime.total_cmp(&a.d_prime).then_with(|| a.image.cmp(&b.image)));
    rows
}
