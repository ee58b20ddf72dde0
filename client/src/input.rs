//! The capture that a command works on.

use crate::failure::Failure;
use crate::output::Output;
use crate::relocate::relocate;
use gonio_diagnose::{AddedFile, Overlay};
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::files::{DirectoryFiles, Files};
use gonio_scene::{Capture, SceneError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A capture and its files: those on disk, and what stands for or beside them in memory.
#[derive(Debug, Clone)]
pub struct Input {
    /// Its folder.
    pub root: PathBuf,
    /// Its files as they lie on disk.
    pub files: DirectoryFiles,
    /// What its `capture.toml` says, or what has been made of that.
    pub capture: Capture,
    /// Files that are in memory alone, such as the meshes that a diagnosis adds. A `capture.toml` among them stands for the one on
    /// disk.
    pub added: Vec<AddedFile>,
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
        Ok(Self { root, files, capture, added: Vec::new() })
    }

    /// The same files with another `capture`, of which a farm is sent that instead of the file on disk; `added` come with it.
    ///
    /// # Errors
    /// A capture that cannot be written as text.
    pub fn with(&self, capture: Capture, added: &[AddedFile]) -> Result<Self, Failure> {
        let text: Arc<[u8]> = capture.to_toml()?.into_bytes().into();
        let mut all = vec![(CAPTURE_FILE.to_owned(), text)];
        let old = self.added.iter().filter(|(path, _)| path != CAPTURE_FILE);
        all.extend(added.iter().cloned());
        all.extend(old.filter(|(path, _)| !added.iter().any(|(new, _)| new == path)).cloned());
        Ok(Self { root: self.root.clone(), files: self.files.clone(), capture, added: all })
    }

    /// Writes the capture to the folder `to`, made where it is missing: its `capture.toml`, which leads to the files where they lie,
    /// and those that are in memory alone.
    ///
    /// # Errors
    /// A folder that cannot be written to, or that is the capture's own.
    pub fn save(&self, to: &Path) -> Result<(), Failure> {
        self.write(&Output::create(to, &[CAPTURE_FILE.to_owned()], &self.root, &self.capture)?)
    }

    /// Whether the file `path` is in memory alone.
    pub(crate) fn holds(&self, path: &str) -> bool {
        self.added.iter().any(|(added, _)| added == path)
    }

    /// Writes the capture to the folder `to`, which exists, so that it can be used from there: the files on disk stay where they are,
    /// those in memory are written beside it.
    ///
    /// # Errors
    /// A folder that is missing or cannot be written to.
    pub(crate) fn write(&self, to: &Output) -> Result<(), Failure> {
        let mut here = self.capture.clone();
        relocate(&mut here, &self.root, to.dir())?;
        for (path, bytes) in self.added.iter().filter(|(path, _)| path != CAPTURE_FILE) {
            to.write(path, bytes)?;
            // These lie beside the capture that is written, not beside the one that was read.
            for (object, moved) in self.capture.objects.iter().zip(&mut here.objects) {
                if object.mesh == *path {
                    moved.mesh.clone_from(path);
                }
            }
        }
        to.write(CAPTURE_FILE, here.to_toml()?.as_bytes())?;
        Ok(())
    }
}

impl Files for Input {
    fn read(&self, path: &str) -> gonio_scene::Result<Arc<[u8]>> {
        Overlay { files: &self.files, added: &self.added }.read(path)
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
