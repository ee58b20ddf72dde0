//! What a sweep is about: its file, its capture, and what the farm is sent of them.

use super::without::nulls;
use crate::failure::Failure;
use crate::input::Input;
use gonio_proto::convert::manifest::pack;
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::files::{DirectoryFiles, Files};
use gonio_scene::{Assets, SceneError};
use gonio_sweep::{FrameDigest, Plan, Sweep};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

/// A sweep, planned.
pub(super) struct Planned {
    /// The capture that it varies.
    pub input: Input,
    /// Its frames.
    pub plan: Plan,
    /// What each frame is called.
    pub digests: Vec<FrameDigest>,
    /// What the farm is sent.
    pub files: Rendered,
}

impl Planned {
    /// Reads the sweep's file at `path` and everything that it names, `without` the effects that a `diagnosis` found.
    ///
    /// # Errors
    /// Anything in them that is broken.
    pub fn read(path: &Path, diagnosis: Option<&Path>, without: &[String]) -> Result<Self, Failure> {
        let shown = path.display().to_string();
        let no_file =
            |problem: &str| SceneError::new(shown.as_str(), problem, "name a sweep's file, such as sweep.toml");
        let name = path.file_name().and_then(|name| name.to_str()).ok_or_else(|| no_file("is no file"))?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let beside = DirectoryFiles::new(folder);
        let bytes = beside.read(name).map_err(|error| SceneError { file: shown.clone(), ..error })?;
        let text = std::str::from_utf8(&bytes).map_err(|_| no_file("is not UTF-8 text"))?;
        let sweep = Sweep::parse(&shown, text, gonio_proto::limits::SAMPLES)?;
        let input = Input::open_scene(&folder.join(&sweep.capture))?;
        let nulls = match diagnosis {
            Some(diagnosis) => nulls(diagnosis, without, &input.capture)?,
            None => Vec::new(),
        };
        let plan = sweep.plan_with(&input.capture, &beside, &nulls)?;
        let files = Rendered::new(&input, &plan)?;
        let packed = pack(&files)?;
        let contents: Vec<(String, String)> =
            packed.manifest.files.iter().map(|(path, (digest, _))| (path.clone(), digest.to_string())).collect();
        let digests = plan.digests(&contents, gonio_proto::VERSION)?;
        Ok(Self { input, plan, digests, files })
    }
}

/// The files of a capture under another description, without its photographs: a sweep compares with nothing.
pub(super) struct Rendered {
    files: DirectoryFiles,
    description: Arc<[u8]>,
    /// Paths that are opened for rendering.
    opened: BTreeSet<String>,
    /// Paths that are not, and exist or do not.
    measured: BTreeSet<String>,
}

impl Rendered {
    fn new(input: &Input, plan: &Plan) -> Result<Self, Failure> {
        let opened: BTreeSet<String> = Assets::paths(&plan.capture, false).into_iter().collect();
        let measured = Assets::paths(&plan.capture, true).into_iter().filter(|path| !opened.contains(path)).collect();
        let description = plan.capture.to_toml()?.into_bytes().into();
        Ok(Self { files: input.files.clone(), description, opened, measured })
    }
}

impl Files for Rendered {
    fn read(&self, path: &str) -> gonio_scene::Result<Arc<[u8]>> {
        if path == CAPTURE_FILE {
            return Ok(self.description.clone());
        }
        if self.measured.contains(path) && !self.opened.contains(path) {
            return Err(SceneError::new(path, "is a photograph, which no sweep opens", "compare by `gonio fit`"));
        }
        self.files.read(path)
    }
}
