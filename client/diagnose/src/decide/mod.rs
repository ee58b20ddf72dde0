//! What to do next, and what to conclude: pure functions of what is known ([`Evidence`]) and of what counts ([`Policy`]).
//!
//! Nothing here renders, fits, or remembers. [`next`] follows the course of a diagnosis from its beginning each time it is asked; where it
//! comes upon something that is not known yet, that is the next thing to find out:
//!
//! 1. Fit the base model, look at what it leaves; photographs that are noisier than stated are known by that ([`excess_noise`]).
//! 2. Score every effect at its null; fit the few that promise most ([`shortlist`]).
//! 3. Accept the best of those that matter ([`accept`]), with its rivals ([`rival`]), fit it for good, and go on from there until nothing
//!    matters.
//! 4. Take out what is not missed any more, by the rule that brought it in ([`select`]).
//! 5. Judge what is left on held-out photos, and say so ([`verdict`]).

pub mod accept;
mod noise;
mod rival;
mod select;
mod shortlist;
mod verdict;

pub use noise::{excess_noise, noise_level};
pub use select::{Addition, Course};
pub use shortlist::best_of_each;
pub use verdict::{Decision, Verdict};

use crate::evidence::Evidence;
use crate::policy::Policy;

/// The next thing to find out.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Fit the base model.
    FitBase,
    /// Say what a model leaves of the residuals.
    Look {
        /// The model.
        model: usize,
    },
    /// Score effects at their nulls.
    Score {
        /// The model.
        model: usize,
        /// The effects' names.
        effects: Vec<String>,
    },
    /// Fit a candidate beside a model.
    Fit {
        /// The model.
        model: usize,
        /// Index of the candidate in the model's score pass.
        candidate: usize,
    },
    /// Predict every unit by fits to the others.
    Fold {
        /// The model.
        model: usize,
    },
    /// Fit a model without one of its parts.
    Remove {
        /// The model.
        model: usize,
        /// The part's index.
        part: usize,
    },
    /// Fit a model for good.
    Settle {
        /// The model.
        model: usize,
    },
    /// Judge a last model, and the base, on held-out units.
    Judge {
        /// The last model.
        model: usize,
    },
    /// Nothing is left to find out.
    Finish(Box<Decision>),
}

/// The next thing to find out, or the end.
#[must_use]
pub fn next(evidence: &Evidence, policy: &Policy) -> Action {
    match decision(evidence, policy) {
        Ok(decision) => Action::Finish(Box::new(decision)),
        Err(lacking) => lacking,
    }
}

/// The whole course. What it lacks comes back as the error.
fn decision(evidence: &Evidence, policy: &Policy) -> Result<Decision, Action> {
    if evidence.models.is_empty() {
        return Err(Action::FitBase);
    }
    let before = evidence.remains(BASE).ok_or(Action::Look { model: BASE })?;
    let course = select::select(evidence, policy)?;
    let last = match course.model {
        model if model == BASE || evidence.is_settled(model) => model,
        model => evidence.settled(model).ok_or(Action::Settle { model })?,
    };
    let after = evidence.remains(last).ok_or(Action::Look { model: last })?;
    let judged = match evidence.holds_out && last != BASE {
        true => Some(evidence.judged(last).ok_or(Action::Judge { model: last })?),
        false => None,
    };
    Ok(verdict::verdict(evidence, policy, course, last, judged, [before, after]))
}

/// The base model's index.
pub const BASE: usize = 0;

#[cfg(test)]
mod tests;
