//! Why a fit cannot start or go on.

use crate::EvaluateError;
use gonio_scene::SceneError;
use std::path::PathBuf;

/// Every error of [`crate::fit`], displayed as one line that says what to mend.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The capture's free parameters, or a starting value.
    #[error(transparent)]
    Capture(#[from] SceneError),
    /// An option out of its range.
    #[error("{option} is {value}; {mend}")]
    Option {
        /// The option's name.
        option: &'static str,
        /// What it was set to.
        value: String,
        /// What it may be.
        mend: String,
    },
    /// Every photo is held out.
    #[error("capture.toml: photo: every photo has role \"held-out\"; give at least one the role \"fit\"")]
    NoFitPhotos,
    /// There is nothing to compare with.
    #[error("capture.toml: photo: the fitted photos have no pixel to compare with; mend their masks or exposures")]
    NoObservations,
    /// The comparison broke down.
    #[error(
        "photo {photo}: its comparison is {what} at {parameters}; look for NaN in the photo, or start from other values"
    )]
    NotFinite {
        /// The photo's name.
        photo: String,
        /// The statistic's name and value.
        what: String,
        /// Names and values of the parameters.
        parameters: String,
    },
    /// The farm's answer does not match the request.
    #[error("the farm answered {got}, the fit asked for {asked}; give all its parts the same version")]
    Answer {
        /// What came back.
        got: String,
        /// What was requested.
        asked: String,
    },
    /// An evaluation failed.
    #[error(transparent)]
    Evaluate(EvaluateError),
    /// Stopped before anything was evaluated, so that there is nothing to keep.
    #[error("cancelled before the first evaluation ended; nothing was fitted")]
    Cancelled,
    /// A checkpoint could not be read or written.
    #[error("{}: {problem}", path.display())]
    Checkpoint {
        /// The checkpoint's file.
        path: PathBuf,
        /// What is wrong and what to do.
        problem: String,
    },
    /// A checkpoint of another fit.
    #[error("the checkpoint is of another fit: its {what} differs; resume with the same, or start anew")]
    Resume {
        /// What differs.
        what: &'static str,
    },
    /// A checkpoint of the same capture with other files.
    #[error(
        "{file}: is not what it was when the checkpoint was written; put back the file of then, or start anew without --resume"
    )]
    ResumeFile {
        /// The file, as the capture names it.
        file: String,
    },
}
