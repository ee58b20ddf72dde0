//! The commands that prepare data: from raw photographs to what a capture is made of.

pub mod chart;
pub mod composite;
pub mod develop;
pub mod hdr;
mod light;
pub mod matte;
pub mod noise;
pub mod plan;

use crate::failure::Failure;
use gonio_prepare::raw::Options;
use gonio_prepare::stored;
use gonio_scene::SceneError;
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::{Image, is_raw};
use std::path::{Path, PathBuf};

/// An image file that the command line names, turned as it is to be shown; a RAW file developed as `gonio develop` does by
/// default.
fn image(path: &Path) -> Result<Image, Failure> {
    if is_raw(path) {
        return Ok(light::raw(path, Options::default())?.image);
    }
    let (image, orientation) = stored::read(&DirectoryFiles::new("."), &path.display().to_string())?;
    Ok(stored::upright(&image, orientation))
}

/// A text file that the command line names.
pub(super) fn text(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|error| {
        let problem = format!("cannot be read: {error}");
        SceneError::new(path.display().to_string(), problem, "correct the path, or its permissions").into()
    })
}

/// The path of a file beside `out`: map.exr and `preview.png` give map.preview.png.
fn beside(out: &Path, ending: &str) -> PathBuf {
    out.with_extension(ending)
}

/// Writes beside its place and renames, so that nobody reads half of a file.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    std::fs::write(&part, bytes)
        .and_then(|()| std::fs::rename(&part, path))
        .map_err(|error| Failure::Failed(format!("{}: cannot be written: {error}", path.display())))
}
