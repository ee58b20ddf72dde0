//! The unequal-variance normal model of ratings, by maximum likelihood (Dorfman and Alf 1969).

use crate::LEVELS;
use crate::detection::{Detection, corrected};
use crate::normal::{below, density, z};
use nalgebra::{SMatrix, SVector};
use serde::Serialize;

/// How often each rating was given, 1 first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Of real images.
    pub real: [u32; LEVELS],
    /// Of synthetic images.
    pub synthetic: [u32; LEVELS],
}

/// Parameters: intercept, slope, and the criteria between levels.
const PARAMETERS: usize = 2 + LEVELS - 1;
type Parameters = SVector<f64, PARAMETERS>;

impl Counts {
    /// Adds another observer's.
    pub fn add(&mut self, other: &Self) {
        self.real.iter_mut().zip(other.real).for_each(|(a, b)| *a += b);
        self.synthetic.iter_mut().zip(other.synthetic).for_each(|(a, b)| *a += b);
    }

    /// The decision "synthetic" at ratings of `level` (2..=5) and above.
    #[must_use]
    pub fn at(&self, level: u8) -> Detection {
        let above = |counts: &[u32; LEVELS]| counts.iter().skip(usize::from(level) - 1).sum();
        Detection {
            hits: above(&self.synthetic),
            synthetic: self.synthetic.iter().sum(),
            false_alarms: above(&self.real),
            real: self.real.iter().sum(),
        }
    }

    /// The four points (z(F), z(H)), from the strictest criterion to the laxest.
    #[must_use]
    pub fn z_points(&self) -> Vec<(f64, f64)> {
        let point = |level| {
            let d = self.at(level);
            (z(corrected(d.false_alarms, d.real)), z(corrected(d.hits, d.synthetic)))
        };
        (2..=LEVELS as u8).rev().map(point).collect()
    }
}

/// z(H) = intercept + slope z(F): real images have evidence of mean 0 and deviation 1, synthetic ones of mean
/// intercept / slope and deviation 1 / slope.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Roc {
    /// z(H) where z(F) = 0.
    pub intercept: f64,
    /// Slope of the zROC: 1 where both kinds of image are rated with equal spread.
    pub slope: f64,
}

impl Roc {
    /// Fits by Fisher scoring. A fifth of a count is added to every cell (half a count to either side of a binary split,
    /// the log-linear correction), so that an empty level has a place. Absent where the ratings do not determine a line,
    /// such as where only two levels were ever used.
    #[must_use]
    pub fn fit(counts: &Counts) -> Option<Self> {
        let used = (0..LEVELS).filter(|&level| counts.real[level] + counts.synthetic[level] > 0).count();
        if used < 3 {
            return None;
        }
        let cells = |counts: &[u32; LEVELS]| counts.map(|n| f64::from(n) + 1.0 / LEVELS as f64);
        let (real, synthetic) = (cells(&counts.real), cells(&counts.synthetic));
        let mut at = start(counts);
        let mut best = likelihood(&at, &real, &synthetic)?;
        for _ in 0..100 {
            let (gradient, information) = score(&at, &real, &synthetic);
            let step = information.cholesky()?.solve(&gradient);
            // Halved until it climbs: criteria must stay in order, and the slope positive.
            let mut share = 1.0;
            let climbed = loop {
                let next = at + step * share;
                match likelihood(&next, &real, &synthetic) {
                    Some(value) if value >= best => break Some((next, value)),
                    _ if share < 1e-6 => break None,
                    _ => share *= 0.5,
                }
            };
            let Some((next, value)) = climbed else { break };
            (at, best) = (next, value);
            if (step * share).amax() < 1e-9 {
                break;
            }
        }
        Some(Self { intercept: at[0], slope: at[1] })
    }

    /// d_a = intercept sqrt(2 / (1 + slope^2)): the distance of the means over the root mean square of the deviations
    /// (Simpson and Fitter 1973); equal to d' where the slope is 1.
    #[must_use]
    pub fn d_a(&self) -> f64 {
        self.intercept * (2.0 / (1.0 + self.slope * self.slope)).sqrt()
    }

    /// Area below the ROC, the share right in a choice between two images: Phi(d_a / sqrt 2).
    #[must_use]
    pub fn area(&self) -> f64 {
        below(self.d_a() / std::f64::consts::SQRT_2)
    }
}

/// Criteria from the real images' rates, and a slope of 1.
fn start(counts: &Counts) -> Parameters {
    let mut at = Parameters::zeros();
    at[1] = 1.0;
    let trials: u32 = counts.real.iter().sum();
    let mut lower = 0.0;
    for k in 0..LEVELS - 1 {
        lower += f64::from(counts.real[k]) + 1.0 / LEVELS as f64;
        at[2 + k] = z(lower / (f64::from(trials) + 1.0));
    }
    at[0] = counts.at(LEVELS as u8 / 2 + 2).d_prime();
    at
}

/// Standardised criteria of the two kinds: c_k, and slope c_k - intercept.
fn edges(at: &Parameters, k: usize) -> [f64; 2] {
    [at[2 + k], at[1] * at[2 + k] - at[0]]
}

/// Probability of level `k` (from 0) for each kind.
fn cell(at: &Parameters, k: usize) -> [f64; 2] {
    let upper = if k == LEVELS - 1 { [1.0; 2] } else { edges(at, k).map(below) };
    let lower = if k == 0 { [0.0; 2] } else { edges(at, k - 1).map(below) };
    [upper[0] - lower[0], upper[1] - lower[1]]
}

fn likelihood(at: &Parameters, real: &[f64; LEVELS], synthetic: &[f64; LEVELS]) -> Option<f64> {
    if at[1] <= 1e-3 || (1..LEVELS - 1).any(|k| at[2 + k] <= at[1 + k]) {
        return None;
    }
    let mut sum = 0.0;
    for k in 0..LEVELS {
        let [p, q] = cell(at, k);
        if p <= 1e-300 || q <= 1e-300 {
            return None;
        }
        sum += real[k] * libm::log(p) + synthetic[k] * libm::log(q);
    }
    Some(sum)
}

/// Gradient of the log likelihood and the expected information.
fn score(
    at: &Parameters,
    real: &[f64; LEVELS],
    synthetic: &[f64; LEVELS],
) -> (Parameters, SMatrix<f64, PARAMETERS, PARAMETERS>) {
    let edge = |k: usize| {
        let ([c, s], mut d) = (edges(at, k), [Parameters::zeros(); 2]);
        d[0][2 + k] = density(c);
        d[1][0] = -density(s);
        d[1][1] = density(s) * at[2 + k];
        d[1][2 + k] = density(s) * at[1];
        d
    };
    let trials = [real.iter().sum::<f64>(), synthetic.iter().sum::<f64>()];
    let (mut gradient, mut information) = (Parameters::zeros(), SMatrix::zeros());
    for k in 0..LEVELS {
        let zero = [Parameters::zeros(); 2];
        let upper = if k == LEVELS - 1 { zero } else { edge(k) };
        let lower = if k == 0 { zero } else { edge(k - 1) };
        for (kind, p) in cell(at, k).into_iter().enumerate() {
            let d = upper[kind] - lower[kind];
            let count = if kind == 0 { real[k] } else { synthetic[k] };
            gradient += d * (count / p);
            information += d * d.transpose() * (trials[kind] / p);
        }
    }
    (gradient, information)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected counts of a model, in millions.
    fn exact(intercept: f64, slope: f64) -> Counts {
        let at = Parameters::from_row_slice(&[intercept, slope, -0.9, -0.1, 0.5, 1.3]);
        let mut counts = Counts::default();
        for k in 0..LEVELS {
            let [p, q] = cell(&at, k);
            counts.real[k] = (p * 1e8) as u32;
            counts.synthetic[k] = (q * 1e8) as u32;
        }
        counts
    }

    #[test]
    fn exact_ratings_give_their_model_back() {
        for (intercept, slope) in [(0.0, 1.0), (1.2, 1.0), (1.5, 0.7), (0.8, 1.4), (-0.5, 0.9)] {
            let roc = Roc::fit(&exact(intercept, slope)).unwrap();
            assert!((roc.intercept - intercept).abs() < 1e-5 && (roc.slope - slope).abs() < 1e-5, "{roc:?}");
            // The mean m = a / s and deviation 1 / s of the signal: d_a = m / sqrt((1 + 1 / s^2) / 2).
            let closed = (intercept / slope) / (0.5 * (1.0 + slope.powi(-2))).sqrt();
            assert!((roc.d_a() - closed).abs() < 1e-5);
        }
    }

    #[test]
    fn equal_variances_have_one_d_prime_at_every_criterion() {
        let counts = exact(1.2, 1.0);
        for level in 2..=5 {
            assert!((counts.at(level).d_prime() - 1.2).abs() < 1e-5);
        }
        assert!((Roc::fit(&counts).unwrap().d_a() - 1.2).abs() < 1e-5);
    }

    #[test]
    fn perfect_and_empty_levels_stay_finite() {
        let counts = Counts { real: [7, 3, 0, 0, 0], synthetic: [0, 0, 0, 2, 8] };
        let roc = Roc::fit(&counts).unwrap();
        assert!(roc.d_a().is_finite() && roc.d_a() > 2.0 && roc.area() < 1.0, "{roc:?}");
        assert_eq!(Roc::fit(&Counts { real: [5, 0, 0, 0, 1], synthetic: [1, 0, 0, 0, 5] }), None);
    }
}
