//! Where the bytes of a capture's files come from: a folder, or memory when the capture travelled as one object.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::{Result, SceneError};

/// The largest file that [`DirectoryFiles`] reads unless told otherwise: 1 GiB.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// Gives the bytes behind a path that a capture, or a file of a capture, names.
pub trait Files: Send + Sync {
    /// The whole content of `path`, which may be relative (to the capture's folder, `../` included) or absolute.
    ///
    /// # Errors
    /// The file is missing, is no regular file, cannot be read, or is too large.
    fn read(&self, path: &str) -> Result<Arc<[u8]>>;
}

/// The files of a capture that lies on disk.
#[derive(Debug, Clone)]
pub struct DirectoryFiles {
    /// The folder that relative paths start from: the one that holds `capture.toml`.
    pub root: PathBuf,
    /// Files above this size, in bytes, are refused before they are read.
    pub max_bytes: u64,
}

impl DirectoryFiles {
    /// Files relative to `root`, each of at most [`MAX_FILE_BYTES`].
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into(), max_bytes: MAX_FILE_BYTES }
    }

    fn too_large(&self, path: &str, bytes: u64) -> SceneError {
        SceneError::new(
            path,
            format!("is {bytes} bytes, above the limit of {}", self.max_bytes),
            "reduce the file: decimate the mesh or crop the image",
        )
    }
}

impl Files for DirectoryFiles {
    fn read(&self, path: &str) -> Result<Arc<[u8]>> {
        if path.is_empty() {
            return Err(SceneError::new("(empty path)", "is not a file name", "name a file"));
        }
        let full = self.root.join(path);
        let unreadable = |error: &std::io::Error| {
            let problem = match error.kind() {
                std::io::ErrorKind::NotFound => format!("does not exist (looked for {})", full.display()),
                _ => format!("cannot be read ({}): {error}", full.display()),
            };
            SceneError::new(path, problem, "correct the path, or its permissions")
        };
        let metadata = std::fs::metadata(&full).map_err(|error| unreadable(&error))?;
        // A device or a pipe would block or never end.
        if !metadata.is_file() {
            let what = if metadata.is_dir() { "a folder" } else { "no regular file" };
            return Err(SceneError::new(path, format!("is {what} ({})", full.display()), "name a file"));
        }
        if metadata.len() > self.max_bytes {
            return Err(self.too_large(path, metadata.len()));
        }
        let mut bytes = Vec::with_capacity(usize::try_from(metadata.len()).unwrap_or(0));
        // The file may grow between the two calls: the limit holds all the same.
        let count = File::open(&full)
            .and_then(|file| file.take(self.max_bytes.saturating_add(1)).read_to_end(&mut bytes))
            .map_err(|error| unreadable(&error))?;
        if count as u64 > self.max_bytes {
            return Err(self.too_large(path, count as u64));
        }
        Ok(bytes.into())
    }
}

/// The files of a capture that arrived as one object, under the names by which the capture refers to them.
#[derive(Debug, Clone, Default)]
pub struct MemoryFiles(pub BTreeMap<String, Arc<[u8]>>);

impl Files for MemoryFiles {
    fn read(&self, path: &str) -> Result<Arc<[u8]>> {
        self.0.get(path).cloned().ok_or_else(|| {
            SceneError::new(
                path,
                "is not among the files of the packed capture",
                "pack the capture again, with this file",
            )
        })
    }
}

/// The path of a file that `path` refers to: `reference` is relative to the folder of `path`, or absolute.
///
/// Both [`mesh::read`](crate::mesh::read) and [`mesh::dependencies`](crate::mesh::dependencies) name files this way, so
/// that a packed capture finds them again.
pub(crate) fn beside(path: &str, reference: &str) -> String {
    if Path::new(reference).is_absolute() {
        return reference.to_owned();
    }
    match path.rsplit_once('/') {
        Some((folder, _)) => format!("{folder}/{reference}"),
        None => reference.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_are_relative_to_the_file_that_holds_them() {
        assert_eq!(beside("part.gltf", "part.bin"), "part.bin");
        assert_eq!(beside("../meshes/part.gltf", "data/part.bin"), "../meshes/data/part.bin");
        assert_eq!(beside("/a/part.gltf", "../part.bin"), "/a/../part.bin");
        assert_eq!(beside("meshes/part.gltf", "/b/part.bin"), "/b/part.bin");
    }

    #[test]
    fn a_folder_gives_its_files_and_refuses_what_is_none() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("capture")).unwrap();
        std::fs::write(folder.path().join("part.ply"), b"12345678").unwrap();
        let mut files = DirectoryFiles::new(folder.path().join("capture"));
        assert_eq!(&*files.read("../part.ply").unwrap(), b"12345678");
        let absolute = folder.path().join("part.ply");
        assert_eq!(&*files.read(absolute.to_str().unwrap()).unwrap(), b"12345678");

        let missing = files.read("part.ply").unwrap_err();
        assert_eq!(missing.file, "part.ply");
        assert!(missing.problem.contains("does not exist"), "{missing}");
        assert!(files.read("../capture").unwrap_err().problem.contains("folder"));
        assert!(files.read("").is_err());
        files.max_bytes = 7;
        assert!(files.read("../part.ply").unwrap_err().problem.contains("above the limit"));
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_refused_before_it_is_opened() {
        let error = DirectoryFiles::new("/").read("/dev/zero").unwrap_err();
        assert!(error.problem.contains("no regular file"), "{error}");
    }

    #[test]
    fn memory_gives_its_files_by_name() {
        let files = MemoryFiles(BTreeMap::from([("a.ply".to_owned(), Arc::from(*b"ply"))]));
        assert_eq!(&*files.read("a.ply").unwrap(), b"ply");
        assert_eq!(files.read("b.ply").unwrap_err().file, "b.ply");
    }
}
