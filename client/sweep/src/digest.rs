//! What a frame is called: the digest of everything that its bits follow from.

use crate::outputs::Output;
use crate::plan::Plan;
use gonio_scene::capture::{Freed, Photo, Role};
use gonio_scene::{Capture, Result};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// SHA-256 of what a frame is made from.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameDigest([u8; 32]);

impl std::fmt::Display for FrameDigest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl std::fmt::Debug for FrameDigest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self}")
    }
}

impl FrameDigest {
    /// Eight bytes of it, for random numbers of its own.
    #[must_use]
    pub fn seed(&self) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|i| self.0[i]))
    }

    /// The path of one of the frame's files below the sweep's folder.
    #[must_use]
    pub fn path(&self, ending: &str) -> String {
        let hex = self.to_string();
        // 256 folders: none grows too large for a file system to list.
        format!("frames/{}/{hex}.{ending}", &hex[..2])
    }
}

/// Collects what a digest is of. Every field has its length before it, so that no two lists of fields have the same bytes.
#[derive(Clone, Default)]
pub(crate) struct Hasher(Sha256);

impl Hasher {
    pub fn field(&mut self, bytes: &[u8]) {
        self.0.update((bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
    }

    pub fn number(&mut self, number: u64) {
        self.field(&number.to_le_bytes());
    }

    pub fn finish(self) -> [u8; 32] {
        self.0.finalize().into()
    }

    pub fn digest(self) -> FrameDigest {
        FrameDigest(self.finish())
    }
}

impl Plan {
    /// What each frame is called. `files` are the contents of what a render opens, by path, and `version` is the
    /// program's. Frames that show the same have the same name: those that only differ by what another photo alone has,
    /// or that set a number to what it is.
    ///
    /// # Errors
    /// None for a plan that [`Sweep::plan`] made.
    pub fn digests(&self, files: &[(String, String)], version: &str) -> Result<Vec<FrameDigest>> {
        let mut common = Hasher::default();
        common.field(b"gonio frame 1");
        common.field(version.as_bytes());
        common.number(files.len() as u64);
        for (path, digest) in files {
            common.field(path.as_bytes());
            common.field(digest.as_bytes());
        }
        common.number(u64::from(self.samples));
        for output in &self.outputs {
            common.field(output.word().as_bytes());
        }
        if self.outputs.contains(&Output::Png) {
            common.number(self.png_stops.to_bits());
        }
        let known = self.capture.numbers();
        let of_file: Vec<Option<f64>> =
            self.names.iter().map(|name| known.get(name).map(|(value, _)| *value)).collect();
        // Order of names without weight: they are written as a map would list them.
        let mut order: Vec<usize> = (0..self.names.len()).collect();
        order.sort_by_key(|i| &self.names[*i]);
        let mut views: BTreeMap<usize, (Hasher, String)> = BTreeMap::new();
        let mut digests = Vec::with_capacity(self.frames.len());
        for frame in &self.frames {
            let (hasher, prefix) = match views.entry(frame.photo) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(place) => {
                    let photo = &self.capture.photos[frame.photo];
                    let mut hasher = common.clone();
                    hasher.number(frame.photo as u64);
                    hasher.field(view_text(&self.capture, photo)?.as_bytes());
                    place.insert((hasher, format!("photo.{}.", photo.name())))
                }
            };
            let mut hasher = hasher.clone();
            hasher.number(frame.seed);
            for &i in &order {
                let (name, value) = (self.names[i].as_str(), self.points[frame.point][i]);
                let name = match name.strip_prefix(prefix.as_str()) {
                    Some(rest) => format!("photo {rest}"),
                    None if name.starts_with("photo.") => continue,
                    None => name.to_owned(),
                };
                if of_file[i].map(f64::to_bits) != Some(value.to_bits()) {
                    hasher.field(name.as_bytes());
                    hasher.number(value.to_bits());
                }
            }
            digests.push(hasher.digest());
        }
        Ok(digests)
    }
}

/// The text of what photo `index` shows of a capture: without the other photos, the names of files that a render does not
/// open, and what only a fit reads. Photos that are added, renamed or given another role change no frame.
fn view_text(capture: &Capture, photo: &Photo) -> Result<String> {
    let bare = Photo { file: "view".to_owned(), label: None, mask: None, role: Role::Fit, ..photo.clone() };
    let alone = Capture {
        name: String::new(),
        camera: capture.camera.clone(),
        sensor: capture.sensor.clone(),
        tracing: capture.tracing.clone(),
        materials: capture.materials.clone(),
        objects: capture.objects.clone(),
        lights: capture.lights.clone(),
        photos: vec![bare],
        reflectance: Vec::new(),
        fit: Freed::default(),
    };
    alone.to_toml()
}
