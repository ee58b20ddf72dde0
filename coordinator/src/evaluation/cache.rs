//! Captures and photographs that were read before: a fit asks for the same ones a hundred times.

use crate::broker::Failure;
use crate::store::{Blobs, StoreError};
use gonio_proto::convert::manifest::Manifest;
use gonio_proto::{Digest, limits};
use gonio_scene::files::MemoryFiles;
use gonio_scene::{Capture, Photograph};
use lru::LruCache;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex, PoisonError};

/// Captures kept, without their photographs.
const CAPTURES: NonZeroUsize = NonZeroUsize::new(16).unwrap();

/// Bytes of decoded photographs kept.
const PHOTOGRAPH_BYTES: usize = 1 << 30;

/// A capture as its manifest describes it; no other file of it has been read.
#[derive(Debug)]
pub struct Described {
    /// Its text, parsed.
    pub capture: Capture,
    /// Its files.
    pub manifest: Manifest,
}

/// What a photograph depends on: the capture, the photo, and the bits of the level above which a pixel is clipped.
type PhotographKey = (Digest, usize, Option<u64>);

#[derive(Debug)]
struct Photographs {
    kept: LruCache<PhotographKey, Arc<Photograph>>,
    bytes: usize,
}

/// Reads captures and photographs from blobs, and keeps the last ones.
#[derive(Debug)]
pub struct Captures {
    blobs: Blobs,
    /// Held only to look up and to insert, not while reading: two clients may read the same file at once.
    described: Mutex<LruCache<Digest, Arc<Described>>>,
    photographs: Mutex<Photographs>,
}

impl Captures {
    /// Nothing read yet.
    #[must_use]
    pub fn new(blobs: Blobs) -> Self {
        let photographs = Photographs { kept: LruCache::unbounded(), bytes: 0 };
        Self { blobs, described: Mutex::new(LruCache::new(CAPTURES)), photographs: Mutex::new(photographs) }
    }

    /// The capture with the manifest `digest`.
    ///
    /// # Errors
    /// The manifest is missing or broken, or its `capture.toml` is.
    pub async fn describe(&self, digest: Digest) -> Result<Arc<Described>, Failure> {
        let known = self.described.lock().unwrap_or_else(PoisonError::into_inner).get(&digest).cloned();
        if let Some(known) = known {
            return Ok(known);
        }
        let blob = self.blobs.get(digest, limits::MANIFEST_BYTES).await.map_err(of_store)?;
        let read = move || {
            let manifest = Manifest::from_blob(blob).map_err(Failure::of_request)?;
            let text = std::str::from_utf8(&manifest.toml).map_err(Failure::of_request)?;
            let capture = Capture::parse(text).map_err(Failure::of_request)?;
            Ok(Arc::new(Described { capture, manifest }))
        };
        let described = tokio::task::spawn_blocking(read).await.map_err(Failure::of_farm)??;
        self.described.lock().unwrap_or_else(PoisonError::into_inner).put(digest, Arc::clone(&described));
        Ok(described)
    }

    /// Photo (or measured reflectance) `index` of `capture`, which is the described one with some of its numbers changed.
    /// Only this photo's file and mask are read.
    ///
    /// # Errors
    /// A file that is missing or broken.
    pub async fn photograph(
        &self,
        digest: Digest,
        described: &Described,
        capture: &Arc<Capture>,
        index: usize,
    ) -> Result<Arc<Photograph>, Failure> {
        let key = (digest, index, capture.sensor.saturation.map(f64::to_bits));
        let known = self.photographs.lock().unwrap_or_else(PoisonError::into_inner).kept.get(&key).cloned();
        if let Some(known) = known {
            return Ok(known);
        }
        let mut files = BTreeMap::new();
        let target = capture.target(index).ok_or_else(|| Failure::of_request(format!("there is no photo {index}")))?;
        for path in target.files() {
            // A file that is not there is reported by whoever opens it.
            if let Some((blob, size)) = described.manifest.files.get(path) {
                let bytes = self.blobs.get(*blob, *size).await.map_err(of_store)?;
                files.insert(path.clone(), Arc::from(&*bytes));
            }
        }
        let capture = Arc::clone(capture);
        let read = move || {
            let target = capture.target(index).ok_or_else(|| "the photo is gone".to_owned())?;
            let photograph = Photograph::of(&capture, target, &MemoryFiles(files));
            photograph.map(Arc::new).map_err(|error| error.to_string())
        };
        let photograph = tokio::task::spawn_blocking(read).await.map_err(Failure::of_farm)?;
        let photograph = photograph.map_err(Failure::of_request)?;
        self.keep(key, &photograph);
        Ok(photograph)
    }

    fn keep(&self, key: PhotographKey, photograph: &Arc<Photograph>) {
        let size = |p: &Photograph| 12 * p.image.pixels.len() + p.counts.len();
        let mut photographs = self.photographs.lock().unwrap_or_else(PoisonError::into_inner);
        photographs.bytes += size(photograph);
        if let Some(same) = photographs.kept.put(key, Arc::clone(photograph)) {
            photographs.bytes -= size(&same);
        }
        while photographs.bytes > PHOTOGRAPH_BYTES {
            let Some((_, oldest)) = photographs.kept.pop_lru() else { break };
            photographs.bytes -= size(&oldest);
        }
    }
}

fn of_store(error: StoreError) -> Failure {
    match error {
        StoreError::Store(_) => Failure::of_farm(error),
        _ => Failure::of_request(error),
    }
}
