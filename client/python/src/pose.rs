//! How well poses are estimated, and whether synthetic images tell.

use crate::fit::json;
use crate::work::{raise, work};
use gonio::commands::{evaluate as scores, predict as prediction};
use pyo3::prelude::*;

/// Holds estimates against a dataset; `words` are those of `gonio evaluate`. Gives what scores.json holds.
#[pyfunction]
pub fn evaluate(py: Python<'_>, words: Vec<String>) -> PyResult<String> {
    let arguments: scores::EvaluateArguments = gonio::parse(&words).map_err(raise)?;
    json(&work(py, None, |_, _| scores::evaluate(&arguments))?)
}

/// Compares datasets; `words` are those of `gonio predict`. Gives what prediction.json holds, and the report.
#[pyfunction]
pub fn predict(
    py: Python<'_>,
    words: Vec<String>,
    progress: Option<Py<PyAny>>,
    call: String,
) -> PyResult<(String, String)> {
    let arguments: prediction::PredictArguments = gonio::parse(&words).map_err(raise)?;
    let (found, page) =
        work(py, progress, |console, interrupt| prediction::compare(&arguments, console, interrupt, &call))?;
    Ok((json(&found)?, page))
}
