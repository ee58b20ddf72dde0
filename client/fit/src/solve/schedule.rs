//! When the render's noise matters and how many samples make it stop.

use crate::uncertainty::Uncertainty;

/// Raises samples until the render's noise moves the estimate by less than a fifth of its standard error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Schedule {
    /// Samples per pixel that are never exceeded.
    pub max: u32,
}

/// Variance of the estimate that is the render's over the rest of it, below which the render's part in the error is below 0.2.
const NEGLIGIBLE: f64 = 0.2 * 0.2;

impl Schedule {
    /// Variance of the estimate that is due to the render, over the variance that remains without it.
    pub fn noise_ratio(uncertainty: &Uncertainty) -> f64 {
        let share = uncertainty.render_share();
        share / (1.0 - share).max(1e-6)
    }

    /// Whether the render's noise no longer matters.
    pub fn is_enough(uncertainty: &Uncertainty) -> bool {
        Self::noise_ratio(uncertainty) <= NEGLIGIBLE
    }

    /// The next number of samples per pixel; `None` where `samples` are enough or the most there may be.
    ///
    /// Fourfold at most: stratified samples converge faster than the 1/n that is assumed here, so that a longer leap
    /// overshoots.
    pub fn next(self, samples: u32, uncertainty: &Uncertainty) -> Option<u32> {
        if samples >= self.max || Self::is_enough(uncertainty) {
            return None;
        }
        let factor = (Self::noise_ratio(uncertainty) / NEGLIGIBLE).clamp(1.5, 4.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let wanted = (f64::from(samples) * factor / 2.0 - 1e-6).ceil() as u32;
        let next = wanted.saturating_mul(2);
        // A last raise by less than half again would cost another evaluation and gain nothing.
        Some(if next >= self.max - self.max / 3 { self.max } else { next })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::PhotoStatistics;

    /// One parameter of curvature 1000 whose estimate's variance is the render's by this share.
    fn known(share: f64) -> Uncertainty {
        let gram = vec![0.0, 0.0, 0.0, 1000.0];
        let noise = vec![0.0, 0.0, 0.0, 1000.0 * share / (1.0 - share)];
        let photo = PhotoStatistics { observations: 1_000_000_000, gram, noise, ..PhotoStatistics::default() };
        Uncertainty::new(&[photo], &[1.0])
    }

    #[test]
    fn raises_fourfold_then_by_what_is_needed_then_no_more() {
        let schedule = Schedule { max: 512 };
        assert_eq!(schedule.next(4, &known(0.5)), Some(16));
        // A ratio of 0.08 wants twice the samples.
        assert_eq!(schedule.next(16, &known(0.08 / 1.08)), Some(32));
        assert_eq!(schedule.next(32, &known(0.03)), None);
        assert_eq!(schedule.next(512, &known(0.5)), None);
        assert_eq!(Schedule { max: 80 }.next(16, &known(0.5)), Some(80));
        assert_eq!(Schedule { max: 10 }.next(4, &known(0.5)), Some(10));
    }
}
