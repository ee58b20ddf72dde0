//! The embedded farm as a diagnosis sees it.

use gonio::farm::Farm;
use gonio_diagnose::{AddedFile, DiagnoseError, Diagnosed, Diagnosis, Options, Workshop, diagnose};
use gonio_fit::{Evaluate, EvaluateError};
use gonio_scene::Capture;
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::files::{Files, MemoryFiles};
use std::ops::ControlFlow;

/// A farm, and a capture's files in memory.
pub struct InMemory<'a> {
    pub farm: &'a Farm,
    pub files: &'a MemoryFiles,
}

impl Workshop for InMemory<'_> {
    fn files(&self) -> &dyn Files {
        self.files
    }

    fn open(&self, capture: &Capture, added: &[AddedFile]) -> Result<Box<dyn Evaluate>, EvaluateError> {
        let refused = |error: &dyn std::fmt::Display| EvaluateError::Refused(error.to_string());
        let mut files = self.files.clone();
        let text = capture.to_toml().map_err(|error| refused(&error))?;
        files.0.insert(CAPTURE_FILE.to_owned(), text.into_bytes().into());
        for (path, bytes) in added {
            files.0.insert(path.clone(), bytes.clone());
        }
        Ok(Box::new(self.farm.open(&files).map_err(|error| refused(&error))?))
    }
}

/// Diagnoses a capture in memory.
///
/// # Errors
/// See [`diagnose`].
pub fn diagnosed(farm: &Farm, files: &MemoryFiles, options: &Options) -> Result<Diagnosed, DiagnoseError> {
    let capture = Capture::read(files)?;
    diagnose(&capture, options, &InMemory { farm, files }, &mut |_| ControlFlow::Continue(()))
}

/// Every finding's effects, best first.
#[must_use]
pub fn named(diagnosis: &Diagnosis) -> Vec<&[String]> {
    diagnosis.found.iter().map(|f| f.effects.as_slice()).collect()
}
