//! A capture in Python's hands: read once, changed in memory, its files opened where they lie.

use crate::array;
use crate::work::{raise, work};
use gonio::{Failure, Input};
use gonio_scene::capture::{Photo, Role, Target};
use gonio_scene::{SceneError, Values};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A capture.
#[pyclass(frozen, module = "gonio._native")]
pub struct Capture {
    held: Mutex<Held>,
}

struct Held {
    input: Input,
    /// Whether the capture is no longer what its files say.
    changed: bool,
}

/// Reads the capture at `path`, a folder or its capture.toml.
#[pyfunction]
pub fn load(py: Python<'_>, path: PathBuf) -> PyResult<Capture> {
    py.detach(|| Input::open(&path)).map(Capture::new).map_err(raise)
}

impl Capture {
    /// In Python's hands.
    pub fn new(input: Input) -> Self {
        Self { held: Mutex::new(Held { input, changed: false }) }
    }

    fn lock(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// As it is now: what is changed later does not reach those who work on this.
    ///
    /// # Errors
    /// A capture that cannot be written as text.
    pub fn snapshot(&self) -> Result<Input, Failure> {
        let mut held = self.lock();
        if held.changed {
            held.input = held.input.with(held.input.capture.clone(), &[])?;
            held.changed = false;
        }
        Ok(held.input.clone())
    }
}

/// Photo values, height x width x 3, and which pixels count, height x width.
type Photographed<'py> = (Bound<'py, PyArray3<f32>>, Bound<'py, PyArray2<bool>>);

#[pymethods]
impl Capture {
    /// Its name.
    #[getter]
    fn name(&self) -> String {
        self.lock().input.capture.name.clone()
    }

    /// The folder that it was read from.
    #[getter]
    fn folder(&self) -> PathBuf {
        self.lock().input.root.clone()
    }

    /// Every number by dotted name, sorted: value, lower bound, upper bound.
    fn numbers(&self) -> BTreeMap<String, (f64, f64, f64)> {
        let numbers = self.lock().input.capture.numbers();
        numbers.into_iter().map(|(name, (value, range))| (name, (value, range.min, range.max))).collect()
    }

    /// Sets numbers by dotted name: all of them, or none where one is refused.
    fn set_numbers(&self, values: Vec<(String, f64)>) -> PyResult<()> {
        let mut held = self.lock();
        let mut capture = held.input.capture.clone();
        capture.set_numbers(&values).map_err(|error| raise(error.into()))?;
        held.input.capture = capture;
        held.changed = true;
        Ok(())
    }

    /// Dotted names that a fit frees, and those of them that keep their colour.
    #[getter]
    fn free(&self) -> (Vec<String>, Vec<String>) {
        let fit = &self.lock().input.capture.fit;
        (fit.parameters.clone(), fit.gray.clone())
    }

    /// The photos' names, in order, and whether each is held out.
    #[getter]
    fn photos(&self) -> Vec<(String, bool)> {
        let held = self.lock();
        let photos = held.input.capture.photos.iter();
        photos.map(|photo| (photo.name().to_owned(), photo.role == Role::HeldOut)).collect()
    }

    /// The objects' names, in order.
    #[getter]
    fn objects(&self) -> Vec<String> {
        self.lock().input.capture.objects.iter().map(|object| object.name.clone()).collect()
    }

    /// A photo's values and which of its pixels count, from its files.
    fn photo<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Photographed<'py>> {
        let input = self.snapshot().map_err(raise)?;
        let values = work(py, None, move |_, _| {
            let photo = input.capture.photos.iter().find(|photo| photo.name() == name).ok_or_else(|| {
                let known: Vec<&str> = input.capture.photos.iter().map(Photo::name).take(20).collect();
                let mend = format!("the photos are: {}", known.join(", "));
                SceneError::new("capture.toml", format!("has no photo {name:?}"), mend)
            })?;
            Ok(Values::of(&input.capture, Target::Photo(photo), &input)?)
        })?;
        let (width, height) = (values.image.width, values.image.height);
        let counts = values.counts.into_pyarray(py).reshape([height as usize, width as usize])?;
        Ok((array::image(py, width, height, values.image.pixels)?, counts))
    }

    /// What its capture.toml says, or would say, in its own folder.
    fn text(&self) -> PyResult<String> {
        self.lock().input.capture.to_toml().map_err(|error| raise(error.into()))
    }

    /// Another one with the same content.
    fn copy(&self) -> PyResult<Self> {
        Ok(Self::new(self.snapshot().map_err(raise)?))
    }

    /// Writes capture.toml, and files that are in memory alone, to the folder `to`.
    fn save(&self, py: Python<'_>, to: PathBuf) -> PyResult<()> {
        let input = self.snapshot().map_err(raise)?;
        py.detach(|| input.save(&to)).map_err(raise)
    }
}
