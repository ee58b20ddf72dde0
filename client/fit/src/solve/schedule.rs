//! When the render's noise matters and how many samples make it stop.

use crate::Normal;

/// Raises samples until the render's noise moves the estimate by less than a fifth of its standard error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Schedule {
    /// Samples per pixel that are never exceeded.
    pub max: u32,
}

/// Render variance over sensor variance below which the render's part in the estimate's error is below 0.2.
const NEGLIGIBLE: f64 = 0.2 * 0.2;

impl Schedule {
    /// Render variance over the variance that remains without it. The estimate's covariance splits in the same
    /// proportion, because the weights are one over their sum; what the model does not explain counts as noise too.
    pub fn noise_ratio(normal: &Normal) -> f64 {
        let share = normal.render_share();
        share / (1.0 - share).max(1e-6) / normal.misfit()
    }

    /// Whether the render's noise no longer matters.
    pub fn is_enough(normal: &Normal) -> bool {
        Self::noise_ratio(normal) <= NEGLIGIBLE
    }

    /// The next number of samples per pixel; `None` where `samples` are enough or the most there may be.
    ///
    /// Fourfold at most: stratified samples converge faster than the 1/n that is assumed here, so that a longer leap
    /// overshoots.
    pub fn next(self, samples: u32, normal: &Normal) -> Option<u32> {
        if samples >= self.max || Self::is_enough(normal) {
            return None;
        }
        let factor = (Self::noise_ratio(normal) / NEGLIGIBLE).clamp(1.5, 4.0);
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

    fn normal(render_share: f64, misfit: f64) -> Normal {
        let chi_square = 1000.0 * misfit;
        let gram = vec![chi_square - 1000.0 * render_share];
        Normal::new(&[PhotoStatistics { observations: 1000, chi_square, gram, ..PhotoStatistics::default() }], &[])
    }

    #[test]
    fn raises_fourfold_then_by_what_is_needed_then_no_more() {
        let schedule = Schedule { max: 512 };
        assert_eq!(schedule.next(4, &normal(0.5, 1.0)), Some(16));
        // A ratio of 0.08 wants twice the samples.
        assert_eq!(schedule.next(16, &normal(0.08 / 1.08, 1.0)), Some(32));
        assert_eq!(schedule.next(32, &normal(0.03, 1.0)), None);
        assert_eq!(schedule.next(512, &normal(0.5, 1.0)), None);
        assert_eq!(Schedule { max: 80 }.next(16, &normal(0.5, 1.0)), Some(80));
        assert_eq!(Schedule { max: 10 }.next(4, &normal(0.5, 1.0)), Some(10));
    }

    #[test]
    fn a_model_that_does_not_fit_needs_no_clean_render() {
        assert!(!Schedule::is_enough(&normal(0.3, 1.0)));
        assert!(Schedule::is_enough(&normal(0.3, 20.0)));
    }
}
