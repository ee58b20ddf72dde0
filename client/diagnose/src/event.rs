//! What a diagnosis tells while it runs: one enum for every front end.

use gonio_fit::FitEvent;
use gonio_scene::Progress;
use serde::Serialize;

/// One event of a diagnosis.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum DiagnoseEvent {
    /// A stage begins.
    Stage {
        /// What it does, for a person.
        text: String,
    },
    /// Something happens in a fit.
    Fit {
        /// What.
        fit: FitEvent,
    },
    /// An evaluation makes progress.
    EvaluationProgress {
        /// Tasks done.
        tasks_done: u64,
        /// Tasks in all.
        tasks: u64,
        /// Camera samples.
        primary_samples: u64,
    },
    /// The score pass has ranked the effects.
    Ranked {
        /// Names and cross-validated gains of chi-square per observation, best first.
        ranking: Vec<(String, f64)>,
        /// The model's chi-square per observation on the photos that it was fitted to.
        reduced_chi_square: f64,
    },
    /// An effect was fitted.
    Refitted {
        /// Its name.
        effect: String,
        /// Cross-validated gain of chi-square per observation.
        gain: f64,
        /// Its standard error.
        standard_error: f64,
        /// Reduced chi-square of the photos fitted to.
        reduced_chi_square: f64,
    },
    /// The model was extended.
    Extended {
        /// By this effect.
        effect: String,
    },
}

impl DiagnoseEvent {
    /// The event of an evaluation's progress.
    #[must_use]
    pub fn progress(p: &Progress) -> Self {
        Self::EvaluationProgress { tasks_done: p.tasks_done, tasks: p.tasks, primary_samples: p.primary_samples }
    }
}
