//! What the commands share that make a capture: paths from its folder, sizes of photos, and its file.

use crate::failure::Failure;
use crate::output::{Output, tell, to_json};
use gonio_calibrate::Draft;
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::files::{DirectoryFiles, Files};
use gonio_scene::image::dimensions;
use gonio_scene::{Capture, Result, SceneError};
use std::path::{Path, PathBuf};

/// The folder of a capture that is to be made.
pub(super) struct Place {
    dir: PathBuf,
    whole: PathBuf,
}

impl Place {
    /// For the file `out`, which must be called `capture.toml`.
    ///
    /// # Errors
    /// Another name, or a folder that cannot be made.
    pub(super) fn new(out: &Path) -> std::result::Result<Self, Failure> {
        let at = out.display().to_string();
        if out.file_name().is_none_or(|name| name != CAPTURE_FILE) {
            return Err(SceneError::new(at, "is no place for a capture", "write --out DIR/capture.toml").into());
        }
        if out.exists() {
            let mend = "name another folder by --out, or remove it: it may hold what you have mended";
            return Err(SceneError::new(at, "exists already", mend).into());
        }
        let dir = out.parent().filter(|dir| !dir.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let whole = std::fs::create_dir_all(dir).and_then(|()| dir.canonicalize()).map_err(|error| {
            SceneError::new(dir.display().to_string(), format!("cannot be created: {error}"), "name another by --out")
        })?;
        Ok(Self { dir: dir.to_owned(), whole })
    }

    /// `file`, which must exist, as the capture names it.
    ///
    /// # Errors
    /// There is no such file.
    pub(super) fn relative(&self, file: &Path) -> Result<String> {
        let missing = |error: std::io::Error| {
            let problem = format!("cannot be read: {error}");
            SceneError::new(file.display().to_string(), problem, "correct the path, or add the file")
        };
        let whole = file.canonicalize().map_err(missing)?;
        let shared = whole.components().zip(self.whole.components()).take_while(|(a, b)| a == b).count();
        let up = self.whole.components().skip(shared).map(|_| "..".to_owned());
        let down = whole.components().skip(shared).map(|part| part.as_os_str().to_string_lossy().into_owned());
        Ok(up.chain(down).collect::<Vec<_>>().join("/"))
    }

    /// A photo as the capture names it, with its width and height in pixels.
    ///
    /// # Errors
    /// There is no such file, or it is no image.
    pub(super) fn photo(&self, file: &Path) -> Result<(String, (u32, u32))> {
        let relative = self.relative(file)?;
        let size = dimensions(&self.files(), &relative)?;
        Ok((relative, size))
    }

    /// Files as the capture will see them.
    pub(super) fn files(&self) -> DirectoryFiles {
        DirectoryFiles::new(&self.dir)
    }

    /// Writes a file that the capture names, beside it.
    ///
    /// # Errors
    /// Another file is there, or a disk that cannot be written to.
    pub(super) fn add(&self, name: &str, bytes: &[u8]) -> std::result::Result<(), Failure> {
        let path = self.dir.join(name);
        if std::fs::read(&path).is_ok_and(|there| there != bytes) {
            let mend = "name another folder by --out, or remove it";
            return Err(
                SceneError::new(path.display().to_string(), "exists already, with another content", mend).into()
            );
        }
        Output::create(&self.dir, &[], &self.dir, &Capture::default())?.write(name, bytes).map(drop)
    }

    /// Writes the draft, reads it back as any command will, and tells what it holds; `more` goes to the JSON object.
    ///
    /// # Errors
    /// Values that the format refuses, or a disk that cannot be written to.
    pub(super) fn write(
        &self,
        draft: &Draft,
        json: bool,
        more: &serde_json::Value,
    ) -> std::result::Result<(), Failure> {
        let text = draft.to_toml()?;
        Capture::parse_beside(&text, &self.files())?;
        let output = Output::create(&self.dir, &[], &self.dir, &Capture::default())?;
        let path = output.write(CAPTURE_FILE, text.as_bytes())?;
        let capture = &draft.capture;
        let guesses = text.lines().filter(|line| line.starts_with("# GUESS:")).count();
        if json {
            let mut object = serde_json::json!({
                "capture": path.display().to_string(),
                "photos": capture.photos.len(),
                "objects": capture.objects.len(),
                "guesses": guesses,
            });
            if let (Some(object), Some(more)) = (object.as_object_mut(), more.as_object()) {
                object.extend(more.clone());
            }
            tell(&to_json(&object)?);
        } else {
            let (photos, objects) = (capture.photos.len(), capture.objects.len());
            let path = path.display();
            tell(&format!("{path}: {photos} photos, {objects} objects, {guesses} guesses, each marked by # GUESS:"));
        }
        Ok(())
    }
}

/// The text of `folder`/`name`.
///
/// # Errors
/// There is no such file, or it is no text.
pub(super) fn text(folder: &Path, name: &str, mend: &str) -> Result<String> {
    let bytes =
        DirectoryFiles::new(folder).read(name).map_err(|error| SceneError { mend: mend.to_owned(), ..error })?;
    String::from_utf8(bytes.to_vec()).map_err(|_| SceneError::new(name, "is no UTF-8 text", mend))
}

/// The name of a capture: that of its folder or of what it was made from.
pub(super) fn name_of(path: &Path) -> String {
    let whole = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    whole.file_stem().map_or_else(|| "capture".to_owned(), |name| name.to_string_lossy().into_owned())
}
