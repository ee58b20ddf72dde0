//! The capture that a command works on.

use crate::failure::Failure;
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::files::DirectoryFiles;
use gonio_scene::{Capture, SceneError};
use std::path::{Path, PathBuf};

/// A capture on disk.
pub struct Input {
    /// Its folder.
    pub root: PathBuf,
    /// Its files.
    pub files: DirectoryFiles,
    /// What its `capture.toml` says.
    pub capture: Capture,
}

impl Input {
    /// Reads the capture at `path`: its folder, or the `capture.toml` inside.
    ///
    /// # Errors
    /// No such capture, or a `capture.toml` that is not the format.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        Self::open_by(path, |files| Capture::read(files))
    }

    /// Reads the capture at `path`, which may be a scene alone, without anything measured.
    ///
    /// # Errors
    /// As [`Input::open`], but for what is missing.
    pub fn open_scene(path: &Path) -> Result<Self, Failure> {
        Self::open_by(path, |files| Capture::read_scene(files))
    }

    fn open_by(path: &Path, read: impl Fn(&DirectoryFiles) -> gonio_scene::Result<Capture>) -> Result<Self, Failure> {
        let root = folder(path)?;
        let files = DirectoryFiles::new(&root);
        let capture = read(&files)?;
        Ok(Self { root, files, capture })
    }
}

/// The folder of the capture at `path`.
///
/// # Errors
/// There is nothing at `path`, or a file of another name.
pub fn folder(path: &Path) -> Result<PathBuf, Failure> {
    let refuse =
        |problem: String, mend: &str| Failure::from(SceneError::new(path.display().to_string(), problem, mend));
    let mend = "name a capture's folder or its capture.toml";
    let metadata = std::fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => refuse("does not exist".to_owned(), mend),
        _ => refuse(format!("cannot be read: {error}"), mend),
    })?;
    if metadata.is_dir() {
        return Ok(path.to_owned());
    }
    if path.file_name().is_none_or(|name| name != CAPTURE_FILE) {
        return Err(refuse("is no capture".to_owned(), mend));
    }
    match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Ok(PathBuf::from(".")),
        Some(parent) => Ok(parent.to_owned()),
        None => Err(refuse("has no folder".to_owned(), mend)),
    }
}
