//! Films and images as numpy arrays. A buffer that has numpy's layout is handed over, not copied.

use gonio_scene::Film;
use numpy::{IntoPyArray, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

/// `pixels` of `width` columns as an array of height x width x 3.
///
/// # Errors
/// Numpy has no memory.
pub fn image<'py>(
    py: Python<'py>,
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    pixels.into_flattened().into_pyarray(py).reshape([height as usize, width as usize, 3])
}

/// The first three channels of a film as an array of height x width x 3.
///
/// # Errors
/// As [`image`].
pub fn colours<'py>(py: Python<'py>, film: &Film) -> PyResult<Bound<'py, PyArray3<f32>>> {
    // Planes become pixels: the one copy between the tracer and numpy.
    let mut pixels = vec![[0.0; 3]; film.width as usize * film.height as usize];
    for (channel, plane) in film.channels.iter().take(3).enumerate() {
        for (pixel, value) in pixels.iter_mut().zip(plane) {
            pixel[channel] = *value;
        }
    }
    image(py, film.width, film.height, pixels)
}

/// Every channel of a film as an array of height x width.
///
/// # Errors
/// As [`image`].
pub fn planes(py: Python<'_>, film: Film) -> PyResult<Vec<Bound<'_, PyArray2<f32>>>> {
    let shape = [film.height as usize, film.width as usize];
    film.channels.into_iter().map(|plane| plane.into_pyarray(py).reshape(shape)).collect()
}
