//! A capture's files with those that an effect has brought.

use gonio_scene::Result;
use gonio_scene::files::Files;
use std::sync::Arc;

/// A file that comes with an effect: path and contents.
pub type AddedFile = (String, Arc<[u8]>);

/// A capture's files with some added.
pub struct Overlay<'a> {
    /// The capture's own.
    pub files: &'a dyn Files,
    /// Path and contents of those added.
    pub added: &'a [AddedFile],
}

impl Files for Overlay<'_> {
    fn read(&self, path: &str) -> Result<Arc<[u8]>> {
        match self.added.iter().find(|(p, _)| p == path) {
            Some((_, bytes)) => Ok(bytes.clone()),
            None => self.files.read(path),
        }
    }
}
