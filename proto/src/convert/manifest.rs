//! A capture as blobs: a manifest that names every file by digest, and the files.

use super::{Digest, Result, WireError, at_most, named};
use crate::{limits, wire};
use bytes::Bytes;
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::files::Files;
use gonio_scene::{Assets, Capture, SceneError, mesh};
use prost::Message;
use std::collections::{BTreeMap, BTreeSet};

/// A capture's manifest, as it arrived.
#[derive(Debug, Clone, PartialEq)]
pub struct Manifest {
    /// The text of `capture.toml`.
    pub toml: Bytes,
    /// Digest and size in bytes of every file, by the path that names it.
    pub files: BTreeMap<String, (Digest, u64)>,
}

impl Manifest {
    /// The blob that [`Manifest::from_blob`] reads; equal manifests have equal blobs.
    #[must_use]
    pub fn to_blob(&self) -> Bytes {
        let entry = |(path, (digest, size_bytes)): (&String, &(Digest, u64))| wire::FileEntry {
            path: path.clone(),
            digest: digest.to_wire(),
            size_bytes: *size_bytes,
        };
        let files = self.files.iter().map(entry).collect();
        wire::CaptureManifest { toml: self.toml.clone(), files }.encode_to_vec().into()
    }

    /// Reads a manifest's blob.
    ///
    /// # Errors
    /// It is no manifest, or breaks the limits of [`limits`].
    pub fn from_blob(blob: Bytes) -> Result<Self> {
        if blob.len() as u64 > limits::MANIFEST_BYTES {
            return Err(WireError::new("CaptureManifest", format!("has {} bytes", blob.len())));
        }
        let manifest = wire::CaptureManifest::decode(blob);
        let manifest = manifest.map_err(|error| WireError::new("CaptureManifest", format!("is none: {error}")))?;
        let field = "CaptureManifest.files";
        at_most(field, manifest.files.len(), limits::FILES)?;
        let mut files = BTreeMap::new();
        for entry in manifest.files {
            let path = named(field, entry.path, limits::PATH_BYTES)?;
            let digest = Digest::from_wire(&format!("{field}.{path}"), &entry.digest)?;
            if entry.size_bytes > limits::BLOB_BYTES {
                let problem = format!("has {} bytes, the limit is {}", entry.size_bytes, limits::BLOB_BYTES);
                return Err(WireError::new(format!("{field}.{path}"), problem));
            }
            if files.insert(path.clone(), (digest, entry.size_bytes)).is_some() {
                return Err(WireError::new(format!("{field}.{path}"), "is there twice"));
            }
        }
        Ok(Self { toml: manifest.toml, files })
    }

    /// The files needed to render: every entry but the photos and masks of `capture`.
    #[must_use]
    pub fn rendered_files<'m>(&'m self, capture: &Capture) -> Vec<(&'m str, Digest)> {
        let rendered: BTreeSet<String> = Assets::paths(capture, false).into_iter().collect();
        let measured: BTreeSet<String> =
            Assets::paths(capture, true).into_iter().filter(|path| !rendered.contains(path)).collect();
        let files = self.files.iter().filter(|(path, _)| !measured.contains(*path));
        files.map(|(path, (digest, _))| (path.as_str(), *digest)).collect()
    }
}

/// A capture that is ready to travel.
#[derive(Debug, Clone)]
pub struct Packed {
    /// What it consists of.
    pub manifest: Manifest,
    /// Photographs and masks that cannot be read, and why. A capture renders without them, but cannot be compared.
    pub absent: BTreeMap<String, SceneError>,
}

/// Reads every file of a capture once and lists them by digest; keeps none in memory.
///
/// # Errors
/// A capture that cannot be parsed; a mesh or map that cannot be read.
pub fn pack(files: &dyn Files) -> gonio_scene::Result<Packed> {
    let toml = Bytes::from_owner(files.read(CAPTURE_FILE)?);
    let capture = Capture::read(files)?;
    let mut packed = Packed { manifest: Manifest { toml, files: BTreeMap::new() }, absent: BTreeMap::new() };
    let meshes: BTreeSet<&str> = capture.objects.iter().map(|object| object.mesh.as_str()).collect();
    let rendered: BTreeSet<String> = Assets::paths(&capture, false).into_iter().collect();
    for path in Assets::paths(&capture, true) {
        match files.read(&path) {
            Ok(bytes) => {
                if meshes.contains(path.as_str()) {
                    for dependency in mesh::dependencies(&path, &bytes)? {
                        let bytes = files.read(&dependency)?;
                        packed.manifest.files.insert(dependency, (Digest::of(&bytes), bytes.len() as u64));
                    }
                }
                packed.manifest.files.insert(path, (Digest::of(&bytes), bytes.len() as u64));
            }
            Err(error) if rendered.contains(&path) => return Err(error),
            Err(error) => {
                packed.absent.insert(path, error);
            }
        }
    }
    Ok(packed)
}
