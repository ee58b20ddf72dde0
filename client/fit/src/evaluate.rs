//! What a fit needs from the world: somebody who evaluates the model. The embedded and the remote farm implement it.

use gonio_scene::{Evaluation, EvaluationRequest, Progress};
use std::ops::ControlFlow;

/// Why an evaluation did not finish.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// The watcher asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// The request or its data is at fault; another try would fail alike. The text names file, key and mend.
    #[error("{0}")]
    Refused(String),
    /// The farm is at fault (unreachable, out of workers); another try may succeed.
    #[error("the farm failed: {0}")]
    Farm(String),
}

/// Sees an evaluation's progress; breaks to cancel it.
pub type Watch<'a> = dyn FnMut(&Progress) -> ControlFlow<()> + 'a;

/// Evaluates one capture at given parameters.
pub trait Evaluate {
    /// Runs one evaluation to its end.
    ///
    /// Equal requests give equal answers, to the last bit.
    ///
    /// # Errors
    /// See [`EvaluateError`].
    fn evaluate(&mut self, request: &EvaluationRequest, watch: &mut Watch<'_>) -> Result<Evaluation, EvaluateError>;
}
