//! Measured reflectance beside photos: an effect must matter to either on its own, so that neither the photos' many pixels
//! drown the files, nor the files' unexplained structure speaks for effects of a camera.

use super::error_gain;
use crate::model::Model;
use crate::select::FLOOR;
use crate::{Options, cross};

/// What matters to a model of both.
pub(crate) struct Beside<'a> {
    model: &'a Model,
    /// Photos come first.
    photos: usize,
    options: &'a Options,
}

impl<'a> Beside<'a> {
    /// `None` where the model's capture does not hold both.
    pub(crate) fn of(model: &'a Model, options: &'a Options) -> Option<Self> {
        let photos = model.capture.photos.len();
        (photos > 0 && !model.capture.reflectance.is_empty()).then_some(Self { model, photos, options })
    }

    /// Observations and chi-square of the photos, and of the files.
    fn sums(&self) -> [(f64, f64); 2] {
        let (photos, files) = self.model.fit.photos.split_at(self.photos);
        [photos, files].map(|all| {
            let observations: u64 = all.iter().map(|p| p.observations).sum();
            (observations as f64, all.iter().map(gonio_scene::PhotoStatistics::loss).sum())
        })
    }

    /// Least gain per observation of the photos that matters to them.
    fn least_of_photos(&self) -> f64 {
        let [(observations, chi_square), _] = self.sums();
        (self.options.smallest_gain * (chi_square / observations.max(1.0) - 1.0)).max(FLOOR)
    }

    /// Least gain per observation of all that could matter to either.
    pub(crate) fn least(&self) -> f64 {
        let [(photos, _), (files, of_files)] = self.sums();
        let part = 1.0 - (1.0 - self.options.smallest_file_gain).powi(2);
        (self.least_of_photos() * photos).min(part * of_files) / (photos + files).max(1.0)
    }

    /// Whether a model's deviances of targets left out are lower than this one's, `here`, by what matters to the photos or
    /// to the files.
    pub(crate) fn matters(&self, here: &[f64], there: &[f64]) -> bool {
        let gains: Vec<f64> = here.iter().zip(there).map(|(b, a)| b - a).collect();
        let [(observations, _), _] = self.sums();
        let photos = gains.get(..self.photos).unwrap_or_default();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // A count.
        let (gain, error) = cross::per_observation(photos, observations as u64);
        let squares = |all: &[f64]| all.iter().skip(self.photos).sum::<f64>();
        let of_files = error_gain(squares(here), squares(there));
        gain >= self.least_of_photos() && gain >= 2.0 * error || of_files >= self.options.smallest_file_gain
    }
}
