//! What a diagnosis has learnt, as one value that can be written to a file and decided upon again without a render.
//!
//! Photos and files of measured reflectance are *units*: each is predicted from the others. Models and score passes are counted in the order
//! in which they came to be; model 0 is the base.

pub(crate) mod gather;
mod model;
mod noise;
mod pass;
mod remains;
mod unit;

pub use model::{Attempt, FittedModel, Folds, Number, Outcome, PartName, Removal};
pub use noise::ChannelNoise;
pub use pass::{Promise, ScorePass, ScoredCandidate};
pub use remains::{HeldOutUnit, Judged, Remains, Structure};
pub use unit::{Unit, UnitKind};

use serde::{Deserialize, Serialize};

/// The form of `evidence.json` that this program writes and reads.
pub const EVIDENCE_FORMAT: u32 = 1;

/// Everything that a decision may look at. Serialised, it is `evidence.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Evidence {
    /// [`EVIDENCE_FORMAT`].
    pub format: u32,
    /// The capture's name.
    pub capture: String,
    /// Names of the effects that are considered.
    pub effects: Vec<String>,
    /// What is fitted to, in the order of every list by unit.
    pub units: Vec<Unit>,
    /// Whether the capture holds photos or files out.
    pub holds_out: bool,
    /// The models that were fitted.
    pub models: Vec<FittedModel>,
    /// The score passes.
    pub passes: Vec<ScorePass>,
    /// Candidates that were fitted beside a model.
    pub attempts: Vec<Attempt>,
    /// Models fitted without one of their parts.
    pub removals: Vec<Removal>,
    /// Model that was fitted for good from another: (from, to).
    pub settled: Vec<(usize, usize)>,
    /// What is left of the residuals, by model.
    pub remains: Vec<Remains>,
    /// The judgement on held-out units, by last model.
    pub judged: Vec<Judged>,
}

impl Evidence {
    /// The score pass of a model.
    #[must_use]
    pub fn pass(&self, model: usize) -> Option<&ScorePass> {
        self.passes.iter().find(|p| p.model == model)
    }

    /// What came of fitting a candidate of a model's score pass.
    #[must_use]
    pub fn attempt(&self, model: usize, candidate: usize) -> Option<&Outcome> {
        self.attempts.iter().find(|a| a.model == model && a.candidate == candidate).map(|a| &a.outcome)
    }

    /// The model fitted without one of its parts.
    #[must_use]
    pub fn without(&self, model: usize, part: usize) -> Option<usize> {
        self.removals.iter().find(|r| r.model == model && r.part == part).map(|r| r.then)
    }

    /// The model fitted for good from another.
    #[must_use]
    pub fn settled(&self, model: usize) -> Option<usize> {
        self.settled.iter().find(|(from, _)| *from == model).map(|(_, to)| *to)
    }

    /// Whether a model was fitted for good.
    #[must_use]
    pub fn is_settled(&self, model: usize) -> bool {
        self.settled.iter().any(|(_, to)| *to == model)
    }

    /// What is left of the residuals under a model.
    #[must_use]
    pub fn remains(&self, model: usize) -> Option<&Remains> {
        self.remains.iter().find(|r| r.model == model)
    }

    /// The judgement of a last model.
    #[must_use]
    pub fn judged(&self, model: usize) -> Option<&Judged> {
        self.judged.iter().find(|j| j.model == model)
    }

    /// Whether every list by unit is as long as the units, and every index is one: what a file may have wrong.
    ///
    /// # Errors
    /// What is wrong, for a message.
    pub fn check(&self) -> Result<(), String> {
        let units = self.units.len();
        let whole = |values: &[f64]| values.len() == units && values.iter().all(|v| v.is_finite());
        for (i, model) in self.models.iter().enumerate() {
            let folds = !matches!(&model.folds, Folds::Known(known) if !whole(known));
            if !(whole(&model.loss) && whole(&model.left_out) && folds) {
                return Err(format!("models.{i}: needs one finite deviance for each of {units} units"));
            }
        }
        for (i, pass) in self.passes.iter().enumerate() {
            if !(whole(&pass.loss) && whole(&pass.left_out)) {
                return Err(format!("passes.{i}: needs one finite deviance for each of {units} units"));
            }
        }
        let attempted = self.attempts.iter().filter_map(|a| match a.outcome {
            Outcome::Model(model) => Some(model),
            _ => None,
        });
        let named = attempted.chain(self.removals.iter().map(|r| r.then)).chain(self.settled.iter().map(|s| s.1));
        match named.chain(self.passes.iter().map(|p| p.model)).find(|model| *model >= self.models.len()) {
            Some(model) => Err(format!("names model {model}, which it does not hold")),
            None => Ok(()),
        }
    }

    /// Whether measured reflectance and no photo is diagnosed.
    #[must_use]
    pub fn files_alone(&self) -> bool {
        !self.units.is_empty() && self.units.iter().all(|u| u.kind == UnitKind::File)
    }

    /// Observations of all units.
    #[must_use]
    pub fn observations(&self) -> f64 {
        self.units.iter().map(|u| u.observations).sum::<f64>().max(1.0)
    }
}
