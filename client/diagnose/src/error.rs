//! Why a diagnosis did not come to its end.

use gonio_fit::{EvaluateError, FitError};
use gonio_scene::SceneError;

/// Why a diagnosis did not come to its end.
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    /// The capture or one of its files is at fault.
    #[error(transparent)]
    Capture(#[from] SceneError),
    /// A fit failed.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// An evaluation failed.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// The observer asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// An option that makes no diagnosis.
    #[error("{option} is {value}; {mend}")]
    Option {
        /// Its name.
        option: &'static str,
        /// What it was.
        value: String,
        /// What to write instead.
        mend: &'static str,
    },
}
