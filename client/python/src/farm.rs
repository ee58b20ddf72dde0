//! Where Python's captures are evaluated.

use crate::work::{raise, work};
use gonio::FarmArguments;
use gonio::commands::farm_for;
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// The farm of this process, with the number of the process that started it.
static EMBEDDED: Mutex<Option<(u32, gonio::farm::Farm)>> = Mutex::new(None);

/// A farm: render threads of this process, or a coordinator behind a URL.
#[pyclass(frozen, module = "gonio._native")]
pub struct Farm {
    /// What it is to Rust.
    pub farm: gonio::farm::Farm,
}

#[pymethods]
impl Farm {
    /// The farm that `words` name as options of a command do: `--farm`, `--token`, `--ca`, `--cert`, `--key`, `--threads`, and
    /// their environment variables. Without any, that of this process, which is started once.
    #[new]
    fn new(py: Python<'_>, words: Vec<String>) -> PyResult<Self> {
        let arguments: FarmArguments = gonio::parse(&words).map_err(raise)?;
        let farm = work(py, None, |_, _| {
            if arguments.farm.is_some() || arguments.threads > 0 {
                return farm_for(&arguments, "python");
            }
            let mut embedded = EMBEDDED.lock().unwrap_or_else(PoisonError::into_inner);
            let here = std::process::id();
            let farm = match embedded.take() {
                Some((process, farm)) if process == here => farm,
                other => {
                    // After a fork its threads are the parent's, and waiting for them to end would never end.
                    std::mem::forget(other);
                    farm_for(&arguments, "python")?
                }
            };
            Ok(embedded.insert((here, farm)).1.clone())
        })?;
        Ok(Self { farm })
    }

    /// Whether its coordinator is another process.
    #[getter]
    fn is_remote(&self) -> bool {
        self.farm.is_remote()
    }
}
