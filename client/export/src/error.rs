//! Why a capture cannot be exported.

use gonio_scene::SceneError;

/// What [`crate::export`] may fail with; each is one line that names file, key and mend.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ExportError {
    /// The capture, or a file that it names.
    #[error(transparent)]
    Capture(#[from] SceneError),
    /// A table of the export that JSON cannot hold.
    #[error("{file}: cannot be written as JSON: {problem}; report this with the capture")]
    Json {
        /// The file that was to be written.
        file: String,
        /// What is wrong.
        problem: String,
    },
}

/// What everything in this crate that can fail returns.
pub type Result<T> = std::result::Result<T, ExportError>;
