//! What a diagnosis returns, and writes as `diagnosis.json`.

use crate::decide::Verdict;
use crate::evidence::{ChannelNoise, Structure};
use gonio_fit::FitResult;
use serde::Serialize;

/// The outcome of a diagnosis. Serialised, it is `diagnosis.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// The capture's name.
    pub capture: String,
    /// In one word.
    pub verdict: Verdict,
    /// What was found, in the order in which it was added.
    pub found: Vec<Finding>,
    /// Every effect that was considered.
    pub candidates: Vec<Considered>,
    /// The fit before.
    pub base: FitResult,
    /// The fit after; that before where nothing was found.
    #[serde(rename = "final")]
    pub last: FitResult,
    /// Red, green and blue noise of the photographs, where it is larger than the sensor is said to have: what chi-square is held against, then.
    pub noise: Option<[ChannelNoise; 3]>,
    /// What is left, where it matters: the covariate that predicts most of it.
    pub unexplained: Option<Structure>,
    /// Chi-square per observation that noise alone gives, above 1 for the render's noise that a pixel's channels share.
    pub dispersion: f64,
    /// Seconds.
    pub seconds: f64,
}

/// One finding.
#[derive(Debug, Clone, Serialize)]
pub struct Finding {
    /// The effect and those that cannot be told from it with these data, best first.
    pub effects: Vec<String>,
    /// What of the capture it is about: a material, a light, a photo; how it was tried. Empty where there is but one way.
    pub subject: String,
    /// Decrease of deviance per observation, on photos that it was not fitted to, that it was added for.
    pub gain: f64,
    /// The numbers that it added.
    pub parameters: Vec<FoundParameter>,
    /// Score statistic when it was added: promised decrease of chi-square over its dispersion.
    pub score: f64,
    /// Chance of that score where no effect is present.
    pub p_value: f64,
    /// Held-out photos before and after all findings; absent where the capture holds none out.
    pub held_out: Option<HeldOut>,
    /// The measurement that would tell the effects apart.
    pub separate_by: String,
}

/// A number that a finding added.
#[derive(Debug, Clone, Serialize)]
pub struct FoundParameter {
    /// Dotted name.
    pub name: String,
    /// Its estimate.
    pub value: f64,
    /// Its standard error, where the data say anything.
    pub standard_error: Option<f64>,
    /// The value that changes nothing; absent for a number that does not exist at the null.
    pub null: Option<f64>,
}

/// The held-out photos before and after.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HeldOut {
    /// Mean gain in log predictive density of an observation, nats.
    pub log_density_gain: f64,
    /// Its standard error between photos.
    pub standard_error: Option<f64>,
    /// Chi-square per observation.
    pub reduced_chi_square_before: f64,
    /// Chi-square per observation.
    pub reduced_chi_square_after: f64,
    /// In photo values.
    pub rmse_before: f64,
    /// In photo values.
    pub rmse_after: f64,
    /// In dB.
    pub psnr_before: Option<f64>,
    /// In dB.
    pub psnr_after: Option<f64>,
}

/// One effect that was considered.
#[derive(Debug, Clone, Serialize)]
pub struct Considered {
    /// Its name.
    pub effect: String,
    /// Where it belongs.
    pub family: crate::effects::Family,
    /// Score statistic at the base model, of its best variant.
    pub score: Option<f64>,
    /// Degrees of freedom of the score.
    pub freedom: Option<usize>,
    /// Chance of that score where no effect is present.
    pub p_value: Option<f64>,
    /// Decrease of chi-square per observation on photos left out one at a time.
    pub gain: Option<f64>,
    /// Its standard error between photos.
    pub gain_standard_error: Option<f64>,
    /// Number and expected change from its null.
    pub expected_change: Vec<(String, f64)>,
    /// Chance that the score test notices an effect of the smallest gain of interest.
    pub power: Option<f64>,
    /// Why it is not among the found; absent for those.
    pub refused_because: Option<String>,
}
