//! How long things took: counts by bounds, as a histogram of Prometheus.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Upper bounds, seconds: 1 ms to 1000 s, two a decade.
pub(crate) const BOUNDS: [f64; 13] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];

/// Counts of durations. Adding one costs two atomic additions.
#[derive(Debug, Default)]
pub struct Distribution {
    /// One for each bound, and one for what is longer than all.
    counts: [AtomicU64; BOUNDS.len() + 1],
    micros: AtomicU64,
}

impl Distribution {
    /// Counts one that took `time`.
    pub fn add(&self, time: Duration) {
        let seconds = time.as_secs_f64();
        let place = BOUNDS.partition_point(|bound| *bound < seconds);
        self.counts[place].fetch_add(1, Ordering::Relaxed);
        let micros = u64::try_from(time.as_micros()).unwrap_or(u64::MAX);
        self.micros.fetch_add(micros, Ordering::Relaxed);
    }

    /// How many were at most as long as each bound, the last of which is infinite.
    pub(crate) fn cumulative(&self) -> [u64; BOUNDS.len() + 1] {
        let mut sum = 0;
        std::array::from_fn(|i| {
            sum += self.counts[i].load(Ordering::Relaxed);
            sum
        })
    }

    /// All of them together, seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        Duration::from_micros(self.micros.load(Ordering::Relaxed)).as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_counts_what_is_not_longer() {
        let distribution = Distribution::default();
        for millis in [0, 1, 2, 1000, 1001, 2_000_000] {
            distribution.add(Duration::from_millis(millis));
        }
        let cumulative = distribution.cumulative();
        assert_eq!((cumulative[0], cumulative[1], cumulative[6], cumulative[7]), (2, 3, 4, 5));
        assert_eq!((cumulative[12], cumulative[13]), (5, 6));
        assert!((distribution.seconds() - 2002.004).abs() < 1e-9);
    }
}
