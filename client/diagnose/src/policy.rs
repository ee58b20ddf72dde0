//! Every number that a decision of a diagnosis depends on. Numbers of the numerics (dampings, grids, samples) stay beside these.

use serde::{Deserialize, Serialize};

/// What is accepted, what is a rival, when something is left unexplained. Deviance is twice the negative logarithm of the predictive
/// density; gains of photos are decreases of deviance per observation (a channel of a pixel), without unit.
///
/// "Matrix" below names the confusion matrix of `tests/confusion`: 26 effects hidden at moderate and at weak strength in made captures, and
/// 40 captures with nothing hidden. "Nulls" are its last 40. None of the shared captures of another renderer was used to set a number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Policy {
    /// Smallest gain of interest: part of the base model's chi-square above 1. A choice of the user's, not a measurement.
    pub smallest_gain: f64,
    /// Smallest gain of interest to measured reflectance: part by which the root of mean squared residuals on files left out must fall.
    /// Derived: two or three free numbers take their share, a tenth of the squares, of the twenty or so independent features that smooth
    /// residuals have; a tenth of the error is a fifth of the squares, twice that.
    pub smallest_file_gain: f64,
    /// Gain below which nothing matters, however small the base's misfit. Calibrated on the nulls: the best candidate gains 0.0003.
    pub floor: f64,
    /// Chance, per score pass, that an effect's score is taken for one where there is none. A choice: 1 in 20.
    pub false_alarms: f64,
    /// Chance of an accident up to which a gain is believed: of so large a sum, had each photo's gain an arbitrary sign
    /// ([`crate::decide::accident`]). Derived: 0.2 refuses one photo of five that gains alone (0.5), and two of six (0.25) unless
    /// the others gain a little, too.
    pub accident: f64,
    /// The same for the difference of two effects that explain the same: they are told apart below it. A choice: 1 in 20.
    pub tell_apart: f64,
    /// A gain, in units of the smallest of interest, from which on it is worth fits to parts of the photos to learn whether the quadratic
    /// is right that refuses it. Calibrated on the matrix: a lamp's radius, which one photo alone shows, was refused without.
    pub second_look: f64,
    /// A number of one photo is suspected where it explains so many times what the same number of the median photo does. Derived: four times
    /// the squares is twice the error.
    pub stands_out: f64,
    /// Number of directions from which on an effect is a pattern. Derived from the catalogue: the largest of the others has six.
    pub pattern: usize,
    /// A pattern must gain so many times what the best effect of few numbers does. Derived: a pattern of degree 3 has 19 numbers and
    /// follows what it likes; where a single number explains two thirds of the same, it is the simpler account.
    pub pattern_price: f64,
    /// Part of what a searched place or a pattern explains at its null that its fit is hoped to keep on photos left out. Calibrated on the
    /// matrix: a wall at a wrong place predicts no other photo before it is searched.
    pub hope: f64,
    /// An effect whose gain is uncertain by more than this part of what it explains is as hopeful. Calibrated on the matrix: light position.
    pub undecided: f64,
    /// A promise must exceed so many of its standard errors between photos to be shortlisted, unless it is worth a second look. Calibrated
    /// on the matrix.
    pub promise_errors: f64,
    /// Effects that are fitted after each score pass, at most; one of few numbers comes besides where all of them are patterns. A bound on time.
    pub shortlist: usize,
    /// An effect that promises less than this part of what the best fitted one gains is not fitted. A bound on time.
    pub worth_fitting: f64,
    /// An effect that promises less than this part of what matters, beside one that was found, is not scored again. A bound on time.
    pub worth_scoring: f64,
    /// No place is searched where a fitted effect leaves less than this part of the misfit. A bound on time: a search takes minutes.
    pub enough: f64,
    /// Chi-square per observation below which a model leaves nothing to look for. Derived: a sensor that is a tenth less noisy than
    /// stated has 0.8.
    pub quiet: f64,
    /// An effect that reaches this part of the best's gain is its rival. Calibrated on the matrix.
    pub rival: f64,
    /// So is one that reaches this part, if photos do not tell the two apart. Calibrated on the matrix.
    pub rival_untold: f64,
    /// So is one that brings the fitted photos' deviance down by this part of what the best does ... Calibrated on the matrix.
    pub rival_fall: f64,
    /// ... from this part of the best's gain on. Calibrated on the matrix.
    pub rival_least: f64,
    /// Effects that a model is extended by, at most: a bound on time, far above what any capture has shown.
    pub most_effects: usize,
    /// Photographs are noisier than stated where the standard deviation of what no neighbour shares is more than so many times the sensor's ...
    /// A choice: less changes no decision.
    pub noisier: f64,
    /// ... by so many standard errors. Derived: a chance of 1 in 1000.
    pub noise_errors: f64,
    /// Chi-square per observation of a base model that is no noise, whatever it depends on. Calibrated on the nulls: at most 1.05.
    pub misfit: f64,
    /// Part of the residuals' variance that a covariate must predict to count as structure. Calibrated on the nulls.
    pub structure: f64,
    /// A model that leaves more than this part of the base's excess over the noise, with structure in it, has explained nothing.
    /// A choice: half.
    pub mostly: f64,
    /// The same where no covariate carries what is left: photographs may be noisier than their sensor is said to be. Calibrated on the matrix.
    pub nearly_all: f64,
}

impl Default for Policy {
    fn default() -> Self {
        Self {
            smallest_gain: 0.02,
            smallest_file_gain: 0.1,
            floor: 0.002,
            false_alarms: 0.05,
            accident: 0.2,
            tell_apart: 0.05,
            second_look: 4.0,
            stands_out: 4.0,
            pattern: 10,
            pattern_price: 1.5,
            hope: 0.5,
            undecided: 0.5,
            promise_errors: 0.8,
            shortlist: 3,
            worth_fitting: 0.25,
            worth_scoring: 0.25,
            enough: 0.1,
            quiet: 0.8,
            rival: 0.93,
            rival_untold: 0.7,
            rival_fall: 0.9,
            rival_least: 0.4,
            most_effects: 8,
            noisier: 1.05,
            noise_errors: 3.0,
            misfit: 1.2,
            structure: 0.02,
            mostly: 0.5,
            nearly_all: 0.8,
        }
    }
}
