//! Why a command did not do what was asked, and the exit code that says so.

use crate::farm::FarmError;
use crate::output::tell_error;
use gonio_diagnose::DiagnoseError;
use gonio_fit::{EvaluateError, FitError};
use gonio_scene::SceneError;

/// A command's failure; the text is one line that says what to mend.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// Exit code 1: the farm or the machine is at fault, another try may succeed.
    #[error("{0}")]
    Failed(String),
    /// Exit code 2: the input or the usage is at fault, another try would fail alike.
    #[error("{0}")]
    Input(String),
    /// Exit code 130: stopped by a signal.
    #[error("{0}")]
    Interrupted(String),
}

impl Failure {
    /// The number that the process returns.
    #[must_use]
    pub fn code(&self) -> u8 {
        match self {
            Self::Failed(_) => 1,
            Self::Input(_) => 2,
            Self::Interrupted(_) => 130,
        }
    }

    /// Writes the failure to stderr, as one line of text or of JSON, and gives the exit code.
    pub(crate) fn tell(&self, json: bool) -> u8 {
        if json {
            let event = serde_json::json!({ "event": "error", "exit_code": self.code(), "message": self.to_string() });
            tell_error(&event.to_string());
        } else if let Self::Interrupted(text) = self {
            tell_error(text);
        } else {
            tell_error(&format!("error: {self}"));
        }
        self.code()
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<EvaluateError> for Failure {
    fn from(error: EvaluateError) -> Self {
        match error {
            EvaluateError::Cancelled => Self::Interrupted("interrupted".to_owned()),
            EvaluateError::Refused(text) => Self::Input(text),
            EvaluateError::Farm(_) => Self::Failed(error.to_string()),
        }
    }
}

impl From<FitError> for Failure {
    fn from(error: FitError) -> Self {
        match error {
            FitError::Evaluate(error) => error.into(),
            FitError::Cancelled => Self::Interrupted(error.to_string()),
            FitError::Answer { .. } => Self::Failed(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<DiagnoseError> for Failure {
    fn from(error: DiagnoseError) -> Self {
        match error {
            DiagnoseError::Capture(error) => error.into(),
            DiagnoseError::Fit(error) => error.into(),
            DiagnoseError::Evaluate(error) => error.into(),
            DiagnoseError::Cancelled => Self::Interrupted("interrupted".to_owned()),
            DiagnoseError::Option { .. } => Self::Input(error.to_string()),
        }
    }
}

impl From<FarmError> for Failure {
    fn from(error: FarmError) -> Self {
        match error {
            FarmError::Capture(_) | FarmError::Access(_) | FarmError::Threads(_) => Self::Input(error.to_string()),
            FarmError::Runtime(_) | FarmError::Changed(_) | FarmError::Farm(_) => Self::Failed(error.to_string()),
        }
    }
}
