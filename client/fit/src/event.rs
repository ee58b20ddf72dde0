//! What a fit tells while it runs: one enum for every front end.

use crate::SolverName;
use gonio_scene::Progress;
use serde::{Deserialize, Serialize};

/// One event of a fit, in the order in which they come: `Started`, then `EvaluationProgress` and `IterationDone` in
/// turns, each of these followed by `StandardErrors` where derivatives were evaluated there, `HeldOut` where there is something to score, `Finished`.
///
/// A resumed fit first repeats the events of what its checkpoint holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum FitEvent {
    /// The request makes sense; evaluations begin.
    Started {
        /// The optimiser.
        solver: SolverName,
        /// Names of the parameters, the order of every list below.
        parameters: Vec<String>,
        /// Where it starts, in physical units.
        start: Vec<f64>,
        /// Photos fitted to.
        fit_photos: usize,
        /// Photos kept for scoring.
        held_out_photos: usize,
        /// Whether it goes on from a checkpoint.
        resumed: bool,
    },
    /// An evaluation makes progress.
    EvaluationProgress(#[serde(with = "ProgressFields")] Progress),
    /// The optimiser has made or refused a step.
    IterationDone(Iteration),
    /// How sure the values of the last iteration are.
    StandardErrors {
        /// The iteration's number.
        iteration: u32,
        /// In parameter order and physical units, as [`crate::Estimate::standard_error`]; `None` where the data say nothing.
        standard_errors: Vec<Option<f64>>,
    },
    /// The fit itself is over; the held-out photos are evaluated now, for the first and only time.
    HeldOut {
        /// Photos scored.
        photos: usize,
    },
    /// Nothing more follows.
    Finished {
        /// Whether the last step was below the tolerance.
        converged: bool,
        /// Iterations done.
        iterations: u32,
        /// Camera samples in all.
        primary_samples: u64,
        /// Wall-clock time in seconds.
        seconds: f64,
    },
}

/// One step of the optimiser.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Iteration {
    /// Counts from 1.
    pub iteration: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// Reduced chi-square where the fit stands now ([`gonio_scene::statistics`]): 1 for a right model, whatever the samples.
    pub loss: f64,
    /// Standard error of `loss` that is due to the render's noise.
    pub standard_error: f64,
    /// Largest move of a parameter: relative for a positive one, in logits for a bounded one, in its own unit for
    /// the rest. 0 where the step was refused.
    pub step: f64,
    /// Whether the fit moved.
    pub accepted: bool,
    /// Where it stands now, in physical units.
    pub parameters: Vec<f64>,
}

/// [`Progress`], which knows no serde, field by field.
#[derive(Serialize)]
#[serde(remote = "Progress")]
struct ProgressFields {
    tasks_done: u64,
    tasks: u64,
    primary_samples: u64,
    loss: f64,
    loss_standard_error: f64,
    workers: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_one_flat_json_object() {
        let progress = Progress { tasks_done: 1, tasks: 4, primary_samples: 9, loss: 2.0, ..Progress::default() };
        assert_eq!(
            serde_json::to_string(&FitEvent::EvaluationProgress(progress)).unwrap(),
            r#"{"event":"evaluation_progress","tasks_done":1,"tasks":4,"primary_samples":9,"loss":2.0,"loss_standard_error":0.0,"workers":0}"#
        );
    }
}
