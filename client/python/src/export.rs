//! Captures in the words of other programs.

use crate::capture::Capture;
use crate::fit::json;
use crate::work::{raise, work};
use gonio::Failure;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Writes a capture for the program `to` into the folder `out`; gives what export.json holds.
#[pyfunction]
pub fn export(py: Python<'_>, capture: &Capture, to: &str, out: PathBuf) -> PyResult<String> {
    let format: gonio_export::Format = to.parse().map_err(|text| raise(Failure::Input(format!("{to}: {text}"))))?;
    let input = capture.snapshot().map_err(raise)?;
    json(&work(py, None, |_, _| gonio::commands::export::write(&input, format, &out))?)
}
