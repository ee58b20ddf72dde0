//! Captures that were fetched and scenes that were prepared, each once, the last ones kept.

use crate::queue::Queue;
use crate::renderer::{Loaded, Renderer, Scene};
use crate::{BlobSource, Meter};
use gonio_proto::convert::manifest::Manifest;
use gonio_proto::convert::request::Class;
use gonio_proto::convert::task::Setup;
use gonio_proto::{Digest, limits};
use gonio_scene::files::MemoryFiles;
use gonio_scene::{Assets, Capture};
use lru::LruCache;
use std::collections::BTreeMap;
use std::hash::Hash;
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::OnceCell;

/// Captures kept, with their meshes and maps.
const CAPTURES: NonZeroUsize = NonZeroUsize::new(4).unwrap();

/// Scenes kept: a solver returns to its last few points, central differences of a capture share its geometry.
const SCENES: NonZeroUsize = NonZeroUsize::new(8).unwrap();

/// Why there is no scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SceneUnavailable {
    /// The capture or the parameters are at fault: nobody could prepare it.
    #[error("{0}")]
    Broken(String),
    /// A file could not be fetched: another worker, or another try, may.
    #[error("{0}")]
    NotFetched(String),
}

type Cell<T> = Arc<OnceCell<T>>;

/// A capture that is loaded.
#[derive(Clone)]
struct Kept {
    loaded: Arc<dyn Loaded>,
    /// Of the files that it was loaded from, its manifest among them.
    bytes: u64,
}

/// What the caches hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Held {
    /// Captures loaded.
    pub captures: u64,
    /// Bytes of their files.
    pub bytes: u64,
    /// Scenes prepared.
    pub scenes: u64,
}

/// The bounded caches of a worker.
pub struct Scenes {
    renderer: Arc<dyn Renderer>,
    /// Where loading and preparing run, so that a worker never takes more threads than it was given.
    queue: Queue,
    meter: Arc<Meter>,
    /// Both held only to find or insert a cell. Whoever comes first fills it; the others wait at the cell, on tokio, not
    /// on a render thread.
    captures: Mutex<LruCache<Digest, Cell<Kept>>>,
    scenes: Mutex<LruCache<Digest, Cell<Arc<dyn Scene>>>>,
}

impl Scenes {
    /// Nothing fetched yet.
    #[must_use]
    pub fn new(renderer: Arc<dyn Renderer>, queue: Queue, meter: Arc<Meter>) -> Self {
        let (captures, scenes) = (Mutex::new(LruCache::new(CAPTURES)), Mutex::new(LruCache::new(SCENES)));
        Self { renderer, queue, meter, captures, scenes }
    }

    /// What is kept, complete.
    pub(crate) fn held(&self) -> Held {
        let captures = self.captures.lock().unwrap_or_else(PoisonError::into_inner);
        let kept: Vec<u64> = captures.iter().filter_map(|(_, cell)| cell.get()).map(|kept| kept.bytes).collect();
        drop(captures);
        let scenes = self.scenes.lock().unwrap_or_else(PoisonError::into_inner);
        let scenes = scenes.iter().filter(|(_, cell)| cell.get().is_some()).count() as u64;
        Held { captures: kept.len() as u64, bytes: kept.iter().sum(), scenes }
    }

    /// The scene of an evaluation; `key` is its [`Setup::scene_key`].
    ///
    /// # Errors
    /// See [`SceneUnavailable`].
    pub async fn get(
        &self,
        key: Digest,
        setup: &Setup,
        blobs: &dyn BlobSource,
    ) -> Result<Arc<dyn Scene>, SceneUnavailable> {
        let cell = find(&self.scenes, key);
        let prepare = async || {
            let loaded = self.loaded(setup, blobs).await?;
            let (numbers, columns) = (setup.numbers.clone(), setup.columns.clone());
            self.on_pool(setup.class, move || loaded.prepare(&numbers, &columns).map_err(broken)).await
        };
        cell.get_or_try_init(prepare).await.cloned()
    }

    async fn loaded(&self, setup: &Setup, blobs: &dyn BlobSource) -> Result<Arc<dyn Loaded>, SceneUnavailable> {
        let cell = find(&self.captures, setup.capture);
        let load = async || {
            let manifest = self.fetch(blobs, setup.capture, "the capture's manifest").await?;
            let mut bytes = manifest.len() as u64;
            let manifest = Manifest::from_blob(manifest).map_err(broken)?;
            let text = std::str::from_utf8(&manifest.toml).map_err(broken)?;
            let capture = Capture::parse(text).map_err(broken)?;
            let mut files = BTreeMap::new();
            for (path, digest) in manifest.rendered_files(&capture) {
                let blob = self.fetch(blobs, digest, path).await?;
                bytes += blob.len() as u64;
                files.insert(path.to_owned(), Arc::from(&*blob));
            }
            let renderer = Arc::clone(&self.renderer);
            self.on_pool(setup.class, move || {
                let assets = Assets::load(&capture, &MemoryFiles(files)).map_err(broken)?;
                Ok(Kept { loaded: renderer.load(capture, assets), bytes })
            })
            .await
        };
        cell.get_or_try_init(load).await.map(|kept| Arc::clone(&kept.loaded))
    }

    async fn fetch(
        &self,
        blobs: &dyn BlobSource,
        digest: Digest,
        what: &str,
    ) -> Result<bytes::Bytes, SceneUnavailable> {
        let blob = blobs.get(digest).await.map_err(|error| SceneUnavailable::NotFetched(format!("{what}: {error}")))?;
        debug_assert!(blob.len() as u64 <= limits::BLOB_BYTES);
        self.meter.fetched_bytes.fetch_add(blob.len() as u64, Relaxed);
        Ok(blob)
    }

    async fn on_pool<T: Send + 'static>(
        &self,
        class: Class,
        work: impl FnOnce() -> Result<T, SceneUnavailable> + Send + 'static,
    ) -> Result<T, SceneUnavailable> {
        let (sender, receiver) = tokio::sync::oneshot::channel();
        self.queue.push(class, move || {
            // Whoever asked may have gone.
            let _ = sender.send(catch_unwind(AssertUnwindSafe(work)));
        });
        match receiver.await {
            Ok(Ok(result)) => result,
            // A panic is a bug, and would be one on every worker.
            Ok(Err(_)) | Err(_) => Err(SceneUnavailable::Broken("preparing the scene panicked".to_owned())),
        }
    }
}

fn find<K: Hash + Eq, V>(cache: &Mutex<LruCache<K, Cell<V>>>, key: K) -> Cell<V> {
    let mut cache = cache.lock().unwrap_or_else(PoisonError::into_inner);
    Arc::clone(cache.get_or_insert(key, Cell::default))
}

#[allow(clippy::needless_pass_by_value)] // Its place is in `map_err`.
fn broken(error: impl ToString) -> SceneUnavailable {
    SceneUnavailable::Broken(error.to_string())
}
