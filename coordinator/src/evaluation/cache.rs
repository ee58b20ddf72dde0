//! Captures and photographs that were read before: a fit asks for the same ones a hundred times, and another capture of the same
//! photographs (a refit, a candidate of a diagnosis) asks for them again.

use crate::aggregate::Measured;
use crate::aggregate::measured::Drawn;
use crate::broker::Failure;
use crate::store::{Blobs, StoreError};
use gonio_proto::convert::design::design_from_blob;
use gonio_proto::convert::manifest::Manifest;
use gonio_proto::{Digest, limits};
use gonio_scene::capture::Target;
use gonio_scene::design::Design;
use gonio_scene::files::MemoryFiles;
use gonio_scene::{Capture, Photograph, Values};
use lru::LruCache;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::{OnceCell, Semaphore};

/// Captures kept, without their photographs.
const CAPTURES: NonZeroUsize = NonZeroUsize::new(16).unwrap();

/// Designs kept; a fit has one.
const DESIGNS: NonZeroUsize = NonZeroUsize::new(8).unwrap();

/// Bytes of decoded photographs kept, those that evaluations hold among them.
const PHOTOGRAPH_BYTES: usize = 512 << 20;

/// Bytes that decoders may take at the same time, in units of [`UNIT`]. One photograph of 24 megapixels takes about all of it.
const DECODER_UNITS: u32 = 720;

/// The unit of [`DECODER_UNITS`]: 1 MiB.
const UNIT: u64 = 1 << 20;

/// Bytes that decoding takes for each pixel: as the file has it (6), as three floats (12), which pixels count, its mask, and a
/// decoder's own buffers.
const BYTES_PER_PIXEL: u64 = 24;

/// A capture as its manifest describes it; no other file of it has been read.
#[derive(Debug)]
pub struct Described {
    /// Its text, parsed.
    pub capture: Capture,
    /// Its files.
    pub manifest: Manifest,
}

/// What a photograph depends on.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct PhotographKey {
    /// Its file and its mask, by their own digests.
    files: Vec<Digest>,
    /// What its camera says, which the files are held against.
    size: (u32, u32),
    /// The bits of the level above which a pixel is clipped.
    saturation: Option<u64>,
    /// The design by which it was drawn from, and its index there.
    drawn: Option<(Digest, usize)>,
    /// Measured reflectance also depends on its keys: the capture, and its index there.
    reflectance: Option<(Digest, usize)>,
}

/// A photograph that is asked for.
#[derive(Clone, Copy)]
pub struct Asking<'a> {
    /// The capture's manifest.
    pub digest: Digest,
    /// The capture as its file is.
    pub described: &'a Described,
    /// The same with some of its numbers changed.
    pub capture: &'a Arc<Capture>,
    /// The design of what is compared; absent, all is.
    pub design: Option<&'a (Digest, Arc<Design>)>,
    /// Index among the capture's targets.
    pub index: usize,
}

type Cell = Arc<OnceCell<Arc<Measured>>>;

#[derive(Debug)]
struct Photographs {
    /// Whoever comes first fills a cell; the others wait for it, and decode nothing.
    kept: LruCache<PhotographKey, Cell>,
}

impl Photographs {
    /// Drops what was not asked for longest, as far as bytes demand.
    fn shrink(&mut self) {
        let bytes = |cell: &Cell| cell.get().map_or(0, |measured| measured.bytes());
        let mut total: usize = self.kept.iter().map(|(_, cell)| bytes(cell)).sum();
        while total > PHOTOGRAPH_BYTES && self.kept.len() > 1 {
            let Some((_, oldest)) = self.kept.pop_lru() else { break };
            total -= bytes(&oldest);
        }
    }
}

/// Reads captures, designs and photographs from blobs, and keeps the last ones.
#[derive(Debug)]
pub struct Captures {
    blobs: Blobs,
    /// Held only to look up and to insert, not while reading: two clients may read the same file at once.
    described: Mutex<LruCache<Digest, Arc<Described>>>,
    designs: Mutex<LruCache<Digest, Arc<Design>>>,
    photographs: Mutex<Photographs>,
    decoders: Semaphore,
}

impl Captures {
    /// Nothing read yet.
    #[must_use]
    pub fn new(blobs: Blobs) -> Self {
        let photographs = Photographs { kept: LruCache::unbounded() };
        Self {
            blobs,
            described: Mutex::new(LruCache::new(CAPTURES)),
            designs: Mutex::new(LruCache::new(DESIGNS)),
            photographs: Mutex::new(photographs),
            decoders: Semaphore::new(DECODER_UNITS as usize),
        }
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

    /// The design `digest`.
    ///
    /// # Errors
    /// It is missing or broken.
    pub async fn design(&self, digest: Digest) -> Result<Arc<Design>, Failure> {
        let known = self.designs.lock().unwrap_or_else(PoisonError::into_inner).get(&digest).cloned();
        if let Some(known) = known {
            return Ok(known);
        }
        let blob = self.blobs.get(digest, limits::DESIGN_BYTES).await.map_err(of_store)?;
        let design = Arc::new(design_from_blob(blob).map_err(Failure::of_request)?);
        self.designs.lock().unwrap_or_else(PoisonError::into_inner).put(digest, Arc::clone(&design));
        Ok(design)
    }

    /// A photo, or measured reflectance. Only its file and mask are read, once for all captures that name the same ones.
    ///
    /// # Errors
    /// A file that is missing or broken; a design that does not cover it.
    pub async fn photograph(&self, asking: Asking<'_>) -> Result<Arc<Measured>, Failure> {
        let Asking { described, capture, index, .. } = asking;
        let target = capture.target(index).ok_or_else(|| Failure::of_request(format!("there is no photo {index}")))?;
        // A file that is not there is reported by whoever opens it.
        let files: Vec<_> =
            target.files().filter_map(|path| Some((path.clone(), *described.manifest.files.get(path)?))).collect();
        let key = key(&asking, target, &files)?;
        let cell = {
            let mut photographs = self.photographs.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::clone(photographs.kept.get_or_insert(key.clone(), Cell::default))
        };
        let read = async || self.read(&asking, &files, key.size).await;
        let measured = match cell.get_or_try_init(read).await {
            Ok(measured) => Arc::clone(measured),
            Err(failure) => {
                // What is empty is no photograph that is worth keeping.
                self.photographs.lock().unwrap_or_else(PoisonError::into_inner).kept.pop(&key);
                return Err(failure);
            }
        };
        self.photographs.lock().unwrap_or_else(PoisonError::into_inner).shrink();
        Ok(measured)
    }

    async fn read(
        &self,
        asking: &Asking<'_>,
        files: &[(String, (Digest, u64))],
        (width, height): (u32, u32),
    ) -> Result<Arc<Measured>, Failure> {
        let bytes = files.iter().map(|(_, (_, size))| size).sum::<u64>();
        let units = (bytes + u64::from(width) * u64::from(height) * BYTES_PER_PIXEL).div_ceil(UNIT);
        // What takes more than there is takes all, alone.
        let units = u32::try_from(units).unwrap_or(u32::MAX).min(DECODER_UNITS);
        let _turn = self.decoders.acquire_many(units).await.map_err(Failure::of_farm)?;
        let mut contents = BTreeMap::new();
        for (path, (blob, size)) in files {
            let bytes = self.blobs.get(*blob, *size).await.map_err(of_store)?;
            contents.insert(path.clone(), Arc::from(&*bytes));
        }
        let (capture, index) = (Arc::clone(asking.capture), asking.index);
        let design = asking.design.map(|(_, design)| Arc::clone(design));
        let decode = move || {
            let target = capture.target(index).ok_or_else(|| "the photo is gone".to_owned())?;
            let values = Values::of(&capture, target, &MemoryFiles(contents)).map_err(|error| error.to_string())?;
            let measured = match design.as_ref().and_then(|design| Some((design.rates(index)?, design.seed))) {
                Some((rates, seed)) => Measured::Drawn(Drawn::new(&values, rates.draw(seed, index))),
                None => Measured::All(Photograph::new(values.image, values.counts, values.clipped)),
            };
            Ok(Arc::new(measured))
        };
        let measured: Result<_, String> = tokio::task::spawn_blocking(decode).await.map_err(Failure::of_farm)?;
        measured.map_err(Failure::of_request)
    }
}

/// What the photograph that is asked for depends on.
fn key(asking: &Asking<'_>, target: Target<'_>, files: &[(String, (Digest, u64))]) -> Result<PhotographKey, Failure> {
    let Asking { digest, capture, design, index, .. } = *asking;
    let photo = capture.photos.get(index);
    let size = photo.map_or((0, 0), |photo| {
        let camera = capture.camera_of(photo);
        (camera.width, camera.height)
    });
    let rates = design.and_then(|(of, design)| Some((of, design.rates(index)?)));
    if let Some((_, rates)) = rates
        && !rates.cover(size.0, size.1)
    {
        let text = format!("the design does not cover the {}x{} pixels of {}", size.0, size.1, target.name());
        return Err(Failure::of_request(text));
    }
    Ok(PhotographKey {
        files: files.iter().map(|(_, (digest, _))| *digest).collect(),
        size,
        saturation: capture.sensor.saturation.map(f64::to_bits),
        drawn: rates.map(|(of, _)| (*of, index)),
        reflectance: photo.is_none().then_some((digest, index)),
    })
}

fn of_store(error: StoreError) -> Failure {
    match error {
        StoreError::Store(_) => Failure::of_farm(error),
        _ => Failure::of_request(error),
    }
}
