//! The readers of mesh and image files: what each format's files give, what each broken file is told, and that no
//! damage to a file ends in more than an error.
//!
//! All files are made here, byte by byte or by the encoders of the libraries that the readers do not use for reading.

// Clippy's `allow-unwrap-in-tests` does not reach the functions that tests share.
#![allow(clippy::unwrap_used)]

mod as_said;
mod as_written;
mod broken_images;
mod broken_meshes;
mod fixture_images;
mod fixture_meshes;
mod images;
mod looks;
mod meshes;
mod mutations;

use std::collections::BTreeMap;
use std::sync::Arc;

use gonio_scene::files::MemoryFiles;

/// A capture's files in memory.
fn files(entries: &[(&str, &[u8])]) -> MemoryFiles {
    MemoryFiles(entries.iter().map(|(name, bytes)| ((*name).to_owned(), Arc::from(*bytes))).collect::<BTreeMap<_, _>>())
}
