//! Fits.

use crate::capture::Capture;
use crate::farm::Farm;
use crate::work::{raise, work};
use gonio::commands::fit::Fitted;
use gonio::{Failure, FitOptions};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A fit's outcome.
#[pyclass(frozen, module = "gonio._native")]
pub struct Fit {
    fitted: Fitted,
    /// What was called, for the report.
    call: String,
}

/// Fits a capture with the options of `gonio fit`; `call` is what the report says of how it was made.
#[pyfunction]
pub fn fit(
    py: Python<'_>,
    capture: &Capture,
    farm: &Farm,
    words: Vec<String>,
    progress: Option<Py<PyAny>>,
    call: String,
) -> PyResult<Fit> {
    let options: FitOptions = gonio::parse(&words).map_err(raise)?;
    let input = capture.snapshot().map_err(raise)?;
    let fitted = work(py, progress, |mut console, interrupt| {
        gonio::commands::fit::fit(&input, &farm.farm, &options, &mut console, interrupt)
    })?;
    Ok(Fit { fitted, call })
}

#[pymethods]
impl Fit {
    /// What fit.json holds.
    fn json(&self) -> PyResult<String> {
        json(&self.fitted.result)
    }

    /// The capture at the estimates.
    fn capture(&self) -> Capture {
        Capture::new(self.fitted.input.clone())
    }

    /// The report, an HTML page.
    fn page(&self, py: Python<'_>) -> String {
        py.detach(|| self.fitted.page(&self.call))
    }

    /// Writes capture.toml, fit.json and report.html to the folder `to`.
    fn save(&self, py: Python<'_>, to: PathBuf) -> PyResult<()> {
        py.detach(|| self.fitted.save(&to, &self.call)).map_err(raise)
    }
}

/// `value` as JSON text.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| raise(Failure::Failed(format!("the result is no JSON: {error}"))))
}
