//! A capture as blobs: a manifest that names every file by digest, and the files.

use super::{Digest, Result, WireError, at_most, named};
use crate::{limits, wire};
use bytes::Bytes;
use gonio_scene::capture::{CAPTURE_FILE, Response};
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
    /// Indices of the photos whose file or mask cannot be read, and why. A capture renders without them, but cannot be
    /// compared.
    pub absent: BTreeMap<usize, SceneError>,
}

/// Reads every file of a capture once and lists them by digest; keeps none in memory.
///
/// # Errors
/// A capture that cannot be parsed; a mesh or map that cannot be read.
pub fn pack(files: &dyn Files) -> gonio_scene::Result<Packed> {
    let capture = Capture::read(files)?;
    let toml = match capture.sensor.response {
        // The file behind the curve stays here: whoever makes photo values has it in the text.
        Response::Curve(_) => capture.to_toml()?.into(),
        _ => Bytes::from_owner(files.read(CAPTURE_FILE)?),
    };
    let mut listed = BTreeMap::new();
    let mut add = |path: &str| -> gonio_scene::Result<()> {
        if !listed.contains_key(path) {
            let bytes = files.read(path)?;
            listed.insert(path.to_owned(), (Digest::of(&bytes), bytes.len() as u64));
        }
        Ok(())
    };
    for path in Assets::paths(&capture, false) {
        add(&path)?;
    }
    for object in &capture.objects {
        for dependency in mesh::dependencies(&object.mesh, &files.read(&object.mesh)?)? {
            add(&dependency)?;
        }
    }
    for path in Assets::named_by_meshes(&capture, files)? {
        add(&path)?;
    }
    let mut absent = BTreeMap::new();
    for (index, target) in capture.targets().enumerate() {
        if let Err(error) = target.files().try_for_each(|path| add(path)) {
            absent.insert(index, error);
        }
    }
    Ok(Packed { manifest: Manifest { toml, files: listed }, absent })
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::files::MemoryFiles;
    use std::sync::Arc;

    const TOML: &str = r#"
        format = 1
        name = "two"
        camera = { width = 4, height = 4, fx = 4.0, fy = 4.0, cx = 2.0, cy = 2.0 }
        [[material]]
        name = "m"
        model = "lambert"
        base_color = [0.5, 0.5, 0.5]
        [[object]]
        name = "o"
        mesh = "part.gltf"
        material = "m"
        object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        [[light]]
        name = "sky"
        kind = "environment"
        map = "sky.hdr"
        [[photo]]
        file = "photos/00.exr"
        camera_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        [[photo]]
        file = "photos/01.exr"
        mask = "mask.png"
        camera_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    "#;

    fn files(with: &[&str]) -> MemoryFiles {
        let gltf = r#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "part.bin", "byteLength": 36}]}"#;
        let all =
            [(CAPTURE_FILE, TOML), ("part.gltf", gltf), ("part.bin", "b"), ("sky.hdr", "s"), ("photos/00.exr", "0")];
        let all = all.into_iter().chain([("photos/01.exr", "1"), ("mask.png", "m")]);
        let kept = all.filter(|(path, _)| with.is_empty() || with.contains(path));
        MemoryFiles(kept.map(|(path, text)| (path.to_owned(), Arc::from(text.as_bytes()))).collect())
    }

    #[test]
    fn a_capture_is_packed_with_everything_it_names() {
        let packed = pack(&files(&[])).unwrap();
        assert!(packed.absent.is_empty());
        let paths: Vec<&str> = packed.manifest.files.keys().map(String::as_str).collect();
        assert_eq!(paths, ["mask.png", "part.bin", "part.gltf", "photos/00.exr", "photos/01.exr", "sky.hdr"]);
        assert_eq!(packed.manifest.files["mask.png"], (Digest::of(b"m"), 1));
        let capture = Capture::parse(TOML).unwrap();
        let rendered: Vec<&str> = packed.manifest.rendered_files(&capture).into_iter().map(|f| f.0).collect();
        assert_eq!(rendered, ["part.bin", "part.gltf", "sky.hdr"]);
        let blob = packed.manifest.to_blob();
        assert_eq!(blob, pack(&files(&[])).unwrap().manifest.to_blob());
        assert_eq!(Manifest::from_blob(blob).unwrap(), packed.manifest);
    }

    #[test]
    fn a_capture_without_photographs_can_travel_and_one_without_meshes_cannot() {
        let packed = pack(&files(&[CAPTURE_FILE, "part.gltf", "part.bin", "sky.hdr", "photos/01.exr"])).unwrap();
        let absent: Vec<_> = packed.absent.iter().map(|(index, error)| (*index, error.file.as_str())).collect();
        assert_eq!(absent, [(0, "photos/00.exr"), (1, "mask.png")]);
        assert_eq!(pack(&files(&[CAPTURE_FILE, "part.gltf", "sky.hdr"])).unwrap_err().file, "part.bin");
    }

    #[test]
    fn a_measured_response_travels_inside_of_the_text() {
        let mut with = files(&[]);
        let toml = TOML.replacen("[[material]]", "[sensor]\nresponse = \"r.json\"\n[[material]]", 1);
        with.0.insert(CAPTURE_FILE.into(), Arc::from(toml.as_bytes()));
        let error = pack(&with).unwrap_err();
        assert_eq!((error.file.as_str(), error.key.as_deref()), ("r.json", Some("sensor.response")));
        let table: Vec<f64> = (0..256).map(|code| (f64::from(code) - 128.0) / 51.0 + 0.1).collect();
        let curve = gonio_scene::capture::ResponseCurve::new([table.clone(), table.clone(), table]).unwrap();
        with.0.insert("r.json".into(), Arc::from(curve.to_json().as_bytes()));
        let packed = pack(&with).unwrap();
        assert!(!packed.manifest.files.contains_key("r.json"));
        // What a coordinator reads is what is here, to the last bit.
        let there = Capture::parse(std::str::from_utf8(&packed.manifest.toml).unwrap()).unwrap();
        assert_eq!(there, Capture::read(&with).unwrap());
        assert_eq!(there.sensor.response, Response::Curve(Arc::new(curve)));
    }

    #[test]
    fn broken_manifests_are_refused() {
        let good = pack(&files(&[])).unwrap().manifest.to_blob();
        let broken = |change: &dyn Fn(&mut wire::CaptureManifest), expected: &str| {
            let mut manifest = wire::CaptureManifest::decode(good.clone()).unwrap();
            change(&mut manifest);
            let error = Manifest::from_blob(manifest.encode_to_vec().into()).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        broken(&|m| m.files[0].digest = Bytes::from_static(b"short"), "a digest has 32");
        broken(&|m| m.files[0].size_bytes = u64::MAX, "the limit is");
        broken(&|m| m.files[1].path = m.files[0].path.clone(), "is there twice");
        broken(&|m| m.files[1].path.clear(), "must have 1 to");
        broken(&|m| m.files = vec![m.files[0].clone(); limits::FILES + 1], "the limit is 10000");
        assert!(Manifest::from_blob(good.slice(..good.len() - 1)).unwrap_err().to_string().contains("is none"));
    }
}
