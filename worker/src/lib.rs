//! A worker of a render farm: pulls tasks from a coordinator, renders them, sends the films back.
//!
//! It keeps nothing that matters: what it fetched and prepared is a bounded cache, keyed by digest. Input and output run on
//! tokio; rendering, preparing and encoding run on one rayon pool, so that leases are renewed however busy it is.

pub mod pull;
pub mod remote;
pub mod renderer;
pub mod scenes;
pub mod source;

pub use source::BlobSource;

use gonio_proto::limits;
use gonio_store::Blobs;
use renderer::Renderer;
use scenes::Scenes;
use std::sync::Arc;

/// A render pool and what it has prepared. Clones share both.
#[derive(Clone)]
pub struct Worker {
    name: String,
    pool: Arc<rayon::ThreadPool>,
    scenes: Arc<Scenes>,
    /// Where captures' files may lie besides with the coordinator.
    store: Option<Blobs>,
}

impl Worker {
    /// A worker with a pool of `threads` render threads (0: one per core), each of which renders one task at a time.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn new(name: &str, threads: usize, renderer: Arc<dyn Renderer>) -> Result<Self, rayon::ThreadPoolBuildError> {
        let threads = if threads == 0 { std::thread::available_parallelism().map_or(1, usize::from) } else { threads };
        let threads = threads.min(limits::SLOTS as usize);
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("render-{i}")).build()?;
        let pool = Arc::new(pool);
        let scenes = Arc::new(Scenes::new(renderer, Arc::clone(&pool)));
        Ok(Self { name: name.to_owned(), scenes, pool, store: None })
    }

    /// The same worker, which looks for captures' files in `store` before it asks a remote coordinator for them.
    #[must_use]
    pub fn with_store(self, store: Blobs) -> Self {
        Self { store: Some(store), ..self }
    }

    /// Tasks that it renders at the same time.
    #[must_use]
    pub fn slots(&self) -> u32 {
        u32::try_from(self.pool.current_num_threads()).unwrap_or(limits::SLOTS)
    }
}
