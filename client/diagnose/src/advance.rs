//! How much better a model predicts photos left out than the one before it.

use crate::cross::per_observation;
use crate::folds;
use crate::model::Model;
use crate::workshop::{Observer, Workshop};
use crate::{DiagnoseError, Options};

/// A gain must exceed so many of its standard errors between photos: one photo alone that gains is one of them, two of six
/// alike are 1.58. Chance has no part in it, [`crate::select::FLOOR`] sees to that; a mishap of one photo has.
pub const ERRORS: f64 = 1.45;
/// A gain is broad if it is so many times what matters, as the photos of an effect that is strong in some and weak in others
/// scatter by nature, and this part of the photos is predicted better. A deviance that falls by so much deserves a second look.
pub const LARGE: f64 = 4.0;
/// See [`LARGE`].
const MAJORITY: f64 = 0.66;

/// From one model to the next, by the same samples of both.
#[derive(Debug, Clone)]
pub struct Advance {
    /// By photo: its deviance before, when it is left out.
    before: Vec<f64>,
    /// The same after.
    there: Vec<f64>,
    observations: u64,
    /// Decrease of the fitted photos' deviance per observation.
    pub fall: f64,
}

impl Advance {
    /// From `before` to each model of `there`, all known by equally many samples; `least` is the gain that matters.
    ///
    /// Where the fitted photos speak for one but the quadratic that predicts the photos left out does not, fits have to tell.
    ///
    /// # Errors
    /// An evaluation or fit that fails, a cancellation.
    pub fn of(
        before: &Model,
        there: &[&Model],
        least: f64,
        options: &Options,
        workshop: &dyn Workshop,
        observer: &mut Observer<'_>,
    ) -> Result<Vec<Self>, DiagnoseError> {
        let options = options.refit();
        let mut start = before.clone();
        // What is left out would gain more than what is fitted: it was mispredicted before.
        let beyond = |end: &&Model| {
            let advance = Self::between(&start, end);
            advance.predicted().0 > advance.fall.max(0.0) + LARGE * least
        };
        if there.iter().any(beyond)
            && let Some(left_out) = folds::left_out(before, &options, workshop, observer)?
        {
            start.left_out = left_out;
        }
        let mut advances = Vec::with_capacity(there.len());
        for model in there {
            let mut advance = Self::between(&start, model);
            if advance.fall >= LARGE * least
                && !advance.matters(least)
                && let Some(left_out) = folds::left_out(model, &options, workshop, observer)?
            {
                advance.there = left_out;
            }
            advances.push(advance);
        }
        Ok(advances)
    }

    /// From one model to another by what is known of both.
    #[must_use]
    pub fn between(before: &Model, there: &Model) -> Self {
        Self {
            before: before.left_out.clone(),
            there: there.left_out.clone(),
            observations: there.observations(),
            fall: before.deviance() - there.deviance(),
        }
    }

    /// Whether the gain is large enough, and no accident of few photos.
    #[must_use]
    pub fn matters(&self, least: f64) -> bool {
        let (gain, error) = self.gain();
        let broad = gain >= LARGE * least && self.share() >= MAJORITY;
        gain >= least && (gain >= ERRORS * error || broad)
    }

    /// Decrease of left-out deviance per observation, and its standard error between photos: at most what the fitted photos
    /// fall by, since what is left out cannot gain more than what is fitted.
    #[must_use]
    pub fn gain(&self) -> (f64, f64) {
        let (gain, error) = self.predicted();
        (gain.min(self.fall), error)
    }

    /// The same without that bound.
    fn predicted(&self) -> (f64, f64) {
        per_observation(&self.gains().collect::<Vec<_>>(), self.observations)
    }

    /// The same beyond another advance from the same model.
    #[must_use]
    pub fn gain_over(&self, other: &Self) -> (f64, f64) {
        let each: Vec<f64> = self.gains().zip(other.gains()).map(|(own, other)| own - other).collect();
        per_observation(&each, self.observations)
    }

    /// Part of the photos that are predicted better.
    fn share(&self) -> f64 {
        self.gains().filter(|gain| *gain > 0.0).count() as f64 / self.before.len().max(1) as f64
    }

    /// By photo: decrease of its deviance when it is left out.
    fn gains(&self) -> impl Iterator<Item = f64> + '_ {
        self.before.iter().zip(&self.there).map(|(before, there)| before - there)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn advance(gains: &[f64]) -> Advance {
        Advance {
            before: vec![1e4; gains.len()],
            there: gains.iter().map(|g| 1e4 - 1e3 * g).collect(),
            observations: 1000 * gains.len() as u64,
            fall: 1.0,
        }
    }

    #[test]
    fn a_gain_matters_that_is_large_and_no_accident_of_one_photo() {
        let least = 0.002;
        assert!(advance(&[0.01, 0.012, 0.009, 0.011, 0.01]).matters(least));
        assert!(!advance(&[0.001, 0.0012, 0.0009, 0.0011, 0.001]).matters(least));
        assert!(!advance(&[0.1, 0.0, -0.001, 0.0, 0.001]).matters(least));
        // Strong in some, weak in others, better in most.
        assert!(advance(&[0.1, 0.001, 0.002, 0.001, -0.001]).matters(least));
    }

    #[test]
    fn advances_are_compared_photo_by_photo() {
        let (gain, error) = advance(&[0.03, 0.01, 0.05]).gain_over(&advance(&[0.02, 0.0, 0.04]));
        assert!((gain - 0.01).abs() < 1e-9 && error < 1e-9, "{gain} {error}");
        assert!((advance(&[0.03, 0.01, 0.05]).gain().0 - 0.03).abs() < 1e-9);
    }
}
