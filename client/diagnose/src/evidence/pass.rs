//! Score passes: what derivatives at the null say about every candidate, without a fit.

use serde::{Deserialize, Serialize};

/// One score pass of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScorePass {
    /// The model.
    pub model: usize,
    /// By unit: the model's deviance by this pass' samples, the same as those of the fits that are compared with it.
    pub loss: Vec<f64>,
    /// By unit: the same under the model fitted to the others.
    pub left_out: Vec<f64>,
    /// Chi-square per observation by this pass' samples.
    pub reduced_chi_square: f64,
    /// Every variant of every effect that was scored.
    pub candidates: Vec<ScoredCandidate>,
}

impl ScorePass {
    /// A candidate by its index.
    #[must_use]
    pub fn candidate(&self, index: usize) -> Option<&ScoredCandidate> {
        self.candidates.iter().find(|c| c.promise.candidate == index)
    }
}

/// What a score pass says of one way in which an effect may be present.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScoredCandidate {
    /// The effect.
    pub effect: String,
    /// How it would be present.
    pub label: String,
    /// Directions that are scored.
    pub directions: usize,
    /// Whether its place has to be searched.
    pub searched: bool,
    /// The photo that all of its numbers belong to, if one alone is suspected.
    pub suspect: Option<usize>,
    /// The numbers, colours and points that its fit frees.
    pub frees: Vec<String>,
    /// Score statistic: chi-square distributed where the effect is absent.
    pub score: f64,
    /// Its degrees of freedom.
    pub freedom: usize,
    /// Chance of such a score where the effect is absent.
    pub p_value: f64,
    /// What it promises.
    pub promise: Promise,
    /// Number and expected change from its null.
    pub expected_change: Vec<(String, f64)>,
}

/// What a candidate promises: decreases of deviance per observation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Promise {
    /// Index of the candidate in its score pass.
    pub candidate: usize,
    /// On the units that it would be fitted to.
    pub explained: f64,
    /// On units left out one at a time.
    pub cross_gain: f64,
    /// Standard error of that between units.
    pub cross_error: f64,
}
