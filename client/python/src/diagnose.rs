//! Diagnoses.

use crate::capture::Capture;
use crate::farm::Farm;
use crate::fit::json;
use crate::work::{raise, work};
use gonio::DiagnoseOptions;
use gonio::commands::diagnose::Outcome;
use pyo3::prelude::*;
use std::path::PathBuf;

/// A diagnosis' outcome.
#[pyclass(frozen, module = "gonio._native")]
pub struct Diagnosis {
    outcome: Outcome,
    /// What was called, for the report.
    call: String,
}

/// Diagnoses a capture with the options of `gonio diagnose`; `call` is what the report says of how it was made.
#[pyfunction]
pub fn diagnose(
    py: Python<'_>,
    capture: &Capture,
    farm: &Farm,
    words: Vec<String>,
    progress: Option<Py<PyAny>>,
    call: String,
) -> PyResult<Diagnosis> {
    let options: DiagnoseOptions = gonio::parse(&words).map_err(raise)?;
    let input = capture.snapshot().map_err(raise)?;
    let outcome = work(py, progress, |mut console, interrupt| {
        gonio::commands::diagnose::diagnose(&input, farm.farm.clone(), &options, &mut console, interrupt)
    })?;
    Ok(Diagnosis { outcome, call })
}

#[pymethods]
impl Diagnosis {
    /// What diagnosis.json holds.
    fn json(&self) -> PyResult<String> {
        json(&self.outcome.diagnosed.diagnosis)
    }

    /// Why what was found could not be held against the held-out photos; absent where it was.
    #[getter]
    fn unjudged(&self) -> Option<String> {
        self.outcome.judged().err().map(|failure| failure.to_string())
    }

    /// The capture extended by what was found.
    fn capture(&self) -> Capture {
        Capture::new(self.outcome.input.clone())
    }

    /// The report, an HTML page.
    fn page(&self, py: Python<'_>) -> String {
        py.detach(|| self.outcome.page(&self.call))
    }

    /// Writes capture.toml, added meshes, diagnosis.json and report.html to the folder `to`.
    fn save(&self, py: Python<'_>, to: PathBuf) -> PyResult<()> {
        py.detach(|| self.outcome.save(&to, &self.call)).map_err(raise)
    }
}
