//! How an estimator did, image by image.

use crate::evaluate::{Evaluation, Measure};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Errors above these, as parts of the diameter, are misses: 0.01 to 0.5.
pub static THRESHOLDS: LazyLock<[f64; 50]> =
    LazyLock::new(|| std::array::from_fn(|i| f64::from(u8::try_from(i + 1).unwrap_or(u8::MAX)) / 100.0));

/// The benchmark's ten thresholds among them: every fifth.
const STRIDE: usize = 5;

/// One image.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// Objects that are to be found.
    pub targets: u32,
    /// How many are, at each threshold.
    pub found: Vec<u32>,
    /// Mean over the targets of the least MSSD as a part of the diameter; infinite where one has no estimate.
    pub error: f64,
}

/// The images of a dataset, by scene and image.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    rows: BTreeMap<(u32, u32), Row>,
}

impl Series {
    /// Of an evaluation that names objects (BOP19).
    #[must_use]
    pub fn of(evaluation: &Evaluation) -> Self {
        let mut rows: BTreeMap<(u32, u32), Row> = BTreeMap::new();
        for group in &evaluation.groups {
            let blank = || Row { targets: 0, found: vec![0; THRESHOLDS.len()], error: 0.0 };
            let row = rows.entry((group.scene, group.image)).or_insert_with(blank);
            row.targets += u32::try_from(group.targets()).unwrap_or(u32::MAX);
            for (found, &threshold) in row.found.iter_mut().zip(THRESHOLDS.iter()) {
                let matched = group.matches(threshold, |errors| Measure::Mssd.of(errors)).iter().flatten().count();
                *found += u32::try_from(matched).unwrap_or(u32::MAX);
            }
            let least = |truth: usize| {
                let mine = group.pairs.iter().filter(|pair| pair.truth == truth);
                mine.map(|pair| Measure::Mssd.of(&pair.errors)).fold(f64::INFINITY, f64::min)
            };
            row.error += group.wanted.iter().enumerate().filter(|(_, w)| **w).map(|(i, _)| least(i)).sum::<f64>();
        }
        rows.retain(|_, row| row.targets > 0);
        for row in rows.values_mut() {
            row.error /= f64::from(row.targets);
        }
        Self { rows }
    }

    /// Of images with one target each, by their error.
    #[cfg(test)]
    pub(crate) fn of_errors(errors: &[((u32, u32), f64)]) -> Self {
        let row = |&(image, error): &((u32, u32), f64)| {
            let found = THRESHOLDS.iter().map(|threshold| u32::from(error < *threshold)).collect();
            (image, Row { targets: 1, found, error })
        };
        Self { rows: errors.iter().map(row).collect() }
    }

    /// The rows of the images that both have, and how many only one has.
    pub(crate) fn paired<'a>(&'a self, other: &'a Self) -> (Vec<(&'a Row, &'a Row)>, usize) {
        let pairs: Vec<_> =
            self.rows.iter().filter_map(|(image, row)| other.rows.get(image).map(|b| (row, b))).collect();
        let unpaired = self.rows.len() + other.rows.len() - 2 * pairs.len();
        (pairs, unpaired)
    }

    /// The rows of `images`' order, where all of them are there.
    pub(crate) fn rows(&self) -> &BTreeMap<(u32, u32), Row> {
        &self.rows
    }

    /// Average recall over the benchmark's thresholds.
    #[must_use]
    pub fn average(&self) -> f64 {
        average(&curve(&self.rows.values().collect::<Vec<_>>()))
    }

    /// Each image with its error, as a part of the diameter; infinite for a miss.
    pub fn errors(&self) -> impl Iterator<Item = ((u32, u32), f64)> {
        self.rows.iter().map(|(image, row)| (*image, row.error))
    }
}

/// Recall at every threshold.
pub(super) fn curve(rows: &[&Row]) -> Vec<f64> {
    weighted(rows, &vec![1; rows.len()])
}

/// The same where image i counts `weights[i]` times.
pub(super) fn weighted(rows: &[&Row], weights: &[u32]) -> Vec<f64> {
    let mut found = vec![0.0; THRESHOLDS.len()];
    let mut targets = 0.0;
    for (row, &weight) in rows.iter().zip(weights) {
        if weight == 0 {
            continue;
        }
        let weight = f64::from(weight);
        targets += weight * f64::from(row.targets);
        for (sum, &count) in found.iter_mut().zip(&row.found) {
            *sum += weight * f64::from(count);
        }
    }
    found.into_iter().map(|sum| if targets > 0.0 { sum / targets } else { 0.0 }).collect()
}

/// Mean over the benchmark's thresholds of a curve.
pub(super) fn average(curve: &[f64]) -> f64 {
    let chosen: Vec<f64> = curve.iter().skip(STRIDE - 1).step_by(STRIDE).copied().collect();
    chosen.iter().sum::<f64>() / f64::from(u32::try_from(chosen.len().max(1)).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_average_is_that_of_the_benchmark() {
        let series = Series::of_errors(&[((1, 0), 0.12), ((1, 1), 0.3), ((1, 2), f64::INFINITY)]);
        // Of 0.05, 0.10, ... 0.50 eight are above 0.12 and four above 0.3.
        assert!((series.average() - (8.0 + 4.0) / 30.0).abs() < 1e-12);
    }
}
