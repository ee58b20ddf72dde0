//! Renders as arrays.

use crate::array;
use crate::capture::Capture;
use crate::farm::Farm;
use crate::work::{raise, work};
use gonio::RenderOptions;
use gonio::commands::render::frames;
use gonio_scene::capture::Photo;
use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;

/// A photo's name, its values, and the channels of its first hits where they were asked for.
type Rendered<'py> = (String, Bound<'py, PyArray3<f32>>, Option<Vec<Bound<'py, PyArray2<f32>>>>);

/// Renders `photos` of a capture, all of them where none is named, with the options of `gonio render`.
#[pyfunction]
pub fn render<'py>(
    py: Python<'py>,
    capture: &Capture,
    farm: &Farm,
    photos: Vec<String>,
    words: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<Rendered<'py>>> {
    let mut options: RenderOptions = gonio::parse(&words).map_err(raise)?;
    // Names as they are: on the command line a comma would part them.
    options.photos = photos;
    let input = capture.snapshot().map_err(raise)?;
    let rendered = work(py, progress, |mut console, interrupt| {
        let mut rendered = Vec::new();
        frames(&input, &farm.farm, &options, &mut console, interrupt, &mut |frame, _| {
            rendered.push(frame);
            Ok(())
        })?;
        Ok(rendered)
    })?;
    let name = |photo: usize| input.capture.photos.get(photo).map_or("?", Photo::name).to_owned();
    let one = |frame: gonio::commands::render::Frame| {
        let buffers = frame.buffers.map(|film| array::planes(py, film)).transpose()?;
        Ok((name(frame.photo), array::colours(py, &frame.image)?, buffers))
    };
    rendered.into_iter().map(one).collect()
}
