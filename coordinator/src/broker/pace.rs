//! How long a task takes, by what earlier ones took: it decides how many are handed out at once, never how the work is split.

use std::time::Duration;

/// What one credit should buy, render time of one thread. Long enough that the farm's work per message vanishes beside it,
/// short enough that a worker that is lost takes little along, and that the last batches of an evaluation end together.
pub const TARGET: Duration = Duration::from_millis(300);

/// What a new measurement counts against all before it.
const NEW: f64 = 0.25;

/// Render time per camera sample of one evaluation, on the whole farm or on one worker.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pace {
    /// Microseconds of one render thread; `None` before the first measurement.
    micros_per_sample: Option<f64>,
}

impl Pace {
    /// Adds a measurement: a task of `samples` camera samples took `time`.
    pub fn add(&mut self, samples: u64, time: Duration) {
        #[allow(clippy::cast_precision_loss)]
        let measured = time.as_secs_f64() * 1e6 / samples.max(1) as f64;
        let mean = self.micros_per_sample.map_or(measured, |mean| mean + NEW * (measured - mean));
        self.micros_per_sample = Some(mean);
    }

    /// How long a task of `samples` camera samples will take, if anything is known.
    #[must_use]
    pub fn expect(&self, samples: u64) -> Option<Duration> {
        #[allow(clippy::cast_precision_loss)]
        let micros = self.micros_per_sample? * samples as f64;
        // A worker may claim anything: an hour is long enough for every use of this.
        Some(Duration::from_secs_f64((micros * 1e-6).clamp(0.0, 3600.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_what_is_measured() {
        let mut pace = Pace::default();
        assert_eq!(pace.expect(100), None);
        pace.add(1000, Duration::from_millis(2));
        assert_eq!(pace.expect(500), Some(Duration::from_millis(1)));
        for _ in 0..40 {
            pace.add(1000, Duration::from_millis(8));
        }
        let expected = pace.expect(500).unwrap();
        assert!(expected.abs_diff(Duration::from_millis(4)) < Duration::from_micros(10), "{expected:?}");
        pace.add(0, Duration::MAX);
        assert!(pace.expect(u64::MAX).unwrap() <= Duration::from_secs(3600));
    }
}
