//! What a frame is called: the digest of everything that its bits follow from.

use gonio_scene::capture::{Freed, Photo, Role};
use gonio_scene::{Capture, Result};
use sha2::{Digest as _, Sha256};

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

/// The text of what photo `index` shows of a capture: without the other photos, the names of files that a render does not
/// open, and what only a fit reads. Photos that are added, renamed or given another role change no frame.
pub(crate) fn view_text(capture: &Capture, photo: &Photo) -> Result<String> {
    let bare = Photo { file: "view".to_owned(), mask: None, role: Role::Fit, ..photo.clone() };
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
