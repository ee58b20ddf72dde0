//! What a diagnosis needs from the world: somebody who makes captures ready to be evaluated, and somebody who watches.

use crate::overlay::AddedFile;
use crate::{DiagnoseError, DiagnoseEvent};
use gonio_fit::{Evaluate, EvaluateError};
use gonio_scene::files::Files;
use gonio_scene::{Capture, Evaluation, EvaluationRequest};
use std::ops::ControlFlow;

/// Sees a diagnosis' events; breaks to cancel it.
pub type Observer<'a> = dyn FnMut(&DiagnoseEvent) -> ControlFlow<()> + 'a;

/// Makes captures ready to be evaluated: the embedded farm, or one behind a URL.
pub trait Workshop {
    /// The files of the capture that is diagnosed.
    fn files(&self) -> &dyn Files;
    /// A capture whose files are those of [`Workshop::files`] and `added` (path and contents).
    ///
    /// # Errors
    /// See [`EvaluateError`].
    fn open(&self, capture: &Capture, added: &[AddedFile]) -> Result<Box<dyn Evaluate>, EvaluateError>;
}

/// Runs one evaluation under the observer's eyes.
pub(crate) fn evaluate(
    farm: &mut dyn Evaluate,
    request: &EvaluationRequest,
    observer: &mut Observer<'_>,
) -> Result<Evaluation, DiagnoseError> {
    let done = farm.evaluate(request, &mut |p| observer(&DiagnoseEvent::progress(p)));
    match done {
        Err(EvaluateError::Cancelled) => Err(DiagnoseError::Cancelled),
        other => Ok(other?),
    }
}

/// Tells the observer.
pub(crate) fn tell(observer: &mut Observer<'_>, event: &DiagnoseEvent) -> Result<(), DiagnoseError> {
    match observer(event) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(DiagnoseError::Cancelled),
    }
}
