//! The bootstrap over images (Efron & Tibshirani 1993): images are drawn with replacement, both sets by the same draw.

use super::{Interval, LEVEL};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

/// How often every image counts in every resample.
pub(super) struct Bootstrap {
    weights: Vec<Vec<u32>>,
    count: usize,
}

impl Bootstrap {
    pub fn new(count: usize, resamples: u32, seed: u64) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut draw = || {
            let mut weights = vec![0u32; count];
            for _ in 0..count {
                // 64 bits over some thousand images: the bias is below one part in 10^15.
                #[allow(clippy::cast_possible_truncation)]
                let index = ((u128::from(random.next_u64()) * count as u128) >> 64) as usize;
                if let Some(weight) = weights.get_mut(index) {
                    *weight += 1;
                }
            }
            weights
        };
        Self { weights: (0..resamples).map(|_| draw()).collect(), count }
    }

    /// A statistic of every resample.
    pub fn map<T>(&self, statistic: impl Fn(&[u32]) -> T) -> Vec<T> {
        self.weights.iter().map(|weights| statistic(weights)).collect()
    }

    /// A statistic with its percentile interval.
    pub fn interval(&self, statistic: impl Fn(&[u32]) -> f64) -> Interval {
        let value = statistic(&vec![1; self.count]);
        let mut all = self.map(statistic);
        let low = quantile(&mut all, (1.0 - LEVEL) / 2.0);
        let high = quantile(&mut all, (1.0 + LEVEL) / 2.0);
        Interval { value, low, high }
    }
}

/// The quantile of `values`, which are sorted on the way; 0 of nothing.
pub(super) fn quantile(values: &mut [f64], level: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return 0.0 };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // within the list
    let rank = (level * last as f64).round() as usize;
    values.get(rank).copied().unwrap_or(0.0)
}
