//! What a model leaves of the residuals, and how models do on units that were held out.

use super::ChannelNoise;
use serde::{Deserialize, Serialize};

/// What is left of the residuals under a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Remains {
    /// The model.
    pub model: usize,
    /// Mean square of the residuals, in standard deviations of the sensor, each cut at five: what a firefly cannot raise.
    pub cut_chi_square: f64,
    /// What each covariate explains, strongest first.
    pub structures: Vec<Structure>,
    /// Red, green and blue noise of the photographs; none where too few pixels count, or no photo is.
    pub noise: Option<[ChannelNoise; 3]>,
}

/// The base and a last model on the units that nothing before has read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Judged {
    /// The last model.
    pub model: usize,
    /// Every held-out unit; none where the capture holds none out, or where they could not be read.
    pub units: Vec<HeldOutUnit>,
}

/// One held-out unit under both models.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldOutUnit {
    /// Channels of pixels, or of samples, that count.
    pub observations: f64,
    /// Loss that noise alone is expected to leave.
    pub floor: f64,
    /// Deviance under the base.
    pub before: f64,
    /// Deviance under the last model.
    pub after: f64,
}

impl Judged {
    /// Chi-square per observation before and after; absent without held-out units.
    #[must_use]
    pub fn chi_squares(&self) -> Option<[f64; 2]> {
        let floor: f64 = self.units.iter().map(|u| u.floor).sum();
        let part = |of: fn(&HeldOutUnit) -> f64| self.units.iter().map(of).sum::<f64>() / floor;
        (floor > 0.0).then(|| [part(|u| u.before), part(|u| u.after)])
    }
}

/// What one covariate explains of the residuals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Structure {
    /// The covariate's name.
    pub covariate: String,
    /// Part of the residuals' variance that it predicts in other pixels; 0 for noise, may be slightly negative.
    pub strength: f64,
    /// Per bin: the covariate's mean, the mean residual in standard deviations, and that mean's standard error.
    #[serde(skip)]
    pub curve: Vec<[f64; 3]>,
}
