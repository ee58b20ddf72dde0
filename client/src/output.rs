//! The folder that a command writes to: whole files or none, and never one of the capture's own.

use crate::failure::Failure;
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::{Assets, Capture, SceneError};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

/// An output folder.
#[derive(Debug)]
pub struct Output {
    dir: PathBuf,
}

impl Output {
    /// Creates the folder `dir` where it is missing, and makes sure that none of the files `names` that are to be
    /// written there is one that the capture at `root` consists of.
    ///
    /// # Errors
    /// The folder cannot be created, or a file of the capture would be overwritten.
    pub fn create(dir: &Path, names: &[String], root: &Path, capture: &Capture) -> Result<Self, Failure> {
        std::fs::create_dir_all(dir).map_err(|error| {
            let problem = format!("cannot be created: {error}");
            SceneError::new(dir.display().to_string(), problem, "name a folder that can be written to by --out")
        })?;
        let mut sources = Assets::paths(capture, true);
        sources.push(CAPTURE_FILE.to_owned());
        let sources: BTreeSet<PathBuf> =
            sources.iter().filter_map(|path| root.join(path).canonicalize().ok()).collect();
        for name in names {
            let target = dir.join(name);
            if target.canonicalize().is_ok_and(|path| sources.contains(&path)) {
                let problem = "would be overwritten, and is a file of the capture itself";
                let error = SceneError::new(target.display().to_string(), problem, "name another folder by --out");
                return Err(error.into());
            }
        }
        Ok(Self { dir: dir.to_owned() })
    }

    /// Where the file `name` lies.
    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.join(name)
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Writes the file `name` beside its place and renames it, so that nobody reads half of it.
    ///
    /// # Errors
    /// The disk is full, or not to be written to.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, Failure> {
        let path = self.path(name);
        let mut part = path.as_os_str().to_owned();
        part.push(".part");
        std::fs::write(&part, bytes)
            .and_then(|()| std::fs::rename(&part, &path))
            .map_err(|error| Failure::Failed(format!("{}: cannot be written: {error}", path.display())))?;
        Ok(path)
    }
}

/// Writes a line to standard output; a reader that has seen enough, such as `head`, is no failure.
pub fn tell(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Writes a line to standard error, as [`tell`] does.
pub fn tell_error(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// `value` as JSON text.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn to_json(value: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string(value).map_err(no_json)
}

/// `value` as JSON text with line breaks, for a file that people read too.
///
/// # Errors
/// As [`to_json`].
pub fn to_pretty_json(value: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map_err(no_json)
}

#[allow(clippy::needless_pass_by_value)] // Its place is in `map_err`.
fn no_json(error: serde_json::Error) -> Failure {
    Failure::Failed(format!("the result is no JSON: {error}"))
}
