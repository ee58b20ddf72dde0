//! The Python package `gonio`, as far as it is compiled: `gonio._native`.
//!
//! Every function here reads its options as the command line does ([`gonio::parse`]), runs the command's own code on a thread of its
//! own ([`work::work`]), and gives numbers as numpy arrays and records as JSON. What users see, with its documentation and types,
//! are the Python files beside this crate.

// Python hands its arguments over whole, and pyo3 takes them by value.
#![allow(clippy::needless_pass_by_value)]

mod array;
mod capture;
mod diagnose;
mod export;
mod farm;
mod fit;
mod pose;
mod render;
mod sweep;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::capture::{Capture, load};
    #[pymodule_export]
    use super::diagnose::{Diagnosis, diagnose};
    #[pymodule_export]
    use super::export::export;
    #[pymodule_export]
    use super::farm::Farm;
    #[pymodule_export]
    use super::fit::{Fit, fit};
    #[pymodule_export]
    use super::main;
    #[pymodule_export]
    use super::pose::{evaluate, predict};
    #[pymodule_export]
    use super::render::render;
    #[pymodule_export]
    use super::sweep::Sweep;
    #[pymodule_export]
    use super::work::{GonioError, InputError};
}

/// Runs the command line with `words`, the program's name first; gives the exit code.
#[pyfunction]
fn main(py: Python<'_>, words: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| gonio::run(words))
}
