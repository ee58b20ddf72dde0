//! Models that were fitted, and how each came to be.

use super::Promise;
use serde::{Deserialize, Serialize};

/// A model that was fitted.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FittedModel {
    /// The effects that it has beyond the base, in the order in which they were added.
    pub parts: Vec<PartName>,
    /// By unit: its deviance.
    pub loss: Vec<f64>,
    /// By unit: its deviance under the model fitted to the others, by the quadratic of one evaluation.
    pub left_out: Vec<f64>,
    /// The same by fits, where these were made.
    pub folds: Folds,
    /// Chi-square per observation less free numbers.
    pub reduced_chi_square: f64,
    /// Chi-square per observation that noise alone gives: above 1 for the render's share.
    pub dispersion: f64,
    /// The free numbers.
    pub numbers: Vec<Number>,
    /// What the candidates of the pass that it came from promise beside its last part.
    pub beside: Vec<Promise>,
}

/// An effect that is part of a model.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartName {
    /// The effect's name.
    pub effect: String,
    /// How it is present.
    pub label: String,
    /// The photo that all of its numbers belong to, if one alone is suspected.
    pub suspect: Option<usize>,
}

/// Deviances of units left out, by fits to parts of them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Folds {
    /// Nobody has asked.
    #[default]
    Untried,
    /// A number of one unit is free, which no other predicts, or there are too few units.
    Impossible,
    /// By unit.
    Known(Vec<f64>),
}

/// A free number of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Number {
    /// Its dotted name.
    pub name: String,
    /// Its estimate.
    pub value: f64,
    /// Its standard error, where the data say anything.
    pub standard_error: Option<f64>,
}

/// A candidate fitted beside a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Attempt {
    /// The model that was extended.
    pub model: usize,
    /// Index of the candidate in that model's score pass.
    pub candidate: usize,
    /// What came of it.
    pub outcome: Outcome,
}

/// What came of fitting a candidate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// A model, by its index.
    Model(usize),
    /// No place that was searched explains more.
    Nowhere,
    /// The fit ended where it would be another effect.
    Strayed {
        /// The number that says so.
        name: String,
        /// Its value.
        value: f64,
        /// The least that would still be this effect.
        least: f64,
    },
    /// The fit failed.
    Failed(String),
}

/// A model fitted again without one of its parts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Removal {
    /// The model.
    pub model: usize,
    /// Index of the part that it is fitted without.
    pub part: usize,
    /// The model without.
    pub then: usize,
}
