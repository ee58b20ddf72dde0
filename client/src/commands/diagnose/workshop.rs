//! The farm as a diagnosis sees it: a place that makes one capture after another ready.

use crate::farm::Farm;
use gonio_diagnose::{AddedFile, Overlay, Workshop};
use gonio_fit::{Evaluate, EvaluateError};
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::files::Files;
use gonio_scene::{Capture, Result};
use std::sync::Arc;

/// A farm and the capture's own files.
pub struct FarmWorkshop<'a> {
    /// Where captures are evaluated.
    pub farm: Farm,
    /// The files of the capture that is diagnosed.
    pub files: &'a dyn Files,
}

/// Files with another description.
struct Described<'a> {
    files: Overlay<'a>,
    description: Arc<[u8]>,
}

impl Files for Described<'_> {
    fn read(&self, path: &str) -> Result<Arc<[u8]>> {
        if path == CAPTURE_FILE {
            return Ok(self.description.clone());
        }
        self.files.read(path)
    }
}

impl Workshop for FarmWorkshop<'_> {
    fn files(&self) -> &dyn Files {
        self.files
    }

    fn open(&self, capture: &Capture, added: &[AddedFile]) -> std::result::Result<Box<dyn Evaluate>, EvaluateError> {
        let refused = |error: &dyn std::fmt::Display| EvaluateError::Refused(error.to_string());
        let text = capture.to_toml().map_err(|error| refused(&error))?;
        let files = Described { files: Overlay { files: self.files, added }, description: text.into_bytes().into() };
        let open = self.farm.open(&files).map_err(|error| match error {
            crate::farm::FarmError::Capture(error) => refused(&error),
            other => EvaluateError::Farm(other.to_string()),
        })?;
        Ok(Box::new(open))
    }
}
