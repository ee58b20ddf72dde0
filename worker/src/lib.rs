//! A worker of a render farm: pulls tasks from a coordinator, renders them, sends the films back.
//!
//! It keeps nothing that matters: what it fetched and prepared is a bounded cache, keyed by digest. Input and output run on
//! tokio; rendering, preparing and encoding run on one rayon pool, so that it beats however busy it is.

pub mod access;
mod attempt;
mod batch;
pub mod heart;
mod meter;
pub mod pull;
mod queue;
pub mod remote;
pub mod renderer;
pub mod scenes;
pub mod source;

pub use heart::Heart;
pub use meter::Meter;
pub use source::BlobSource;

use gonio_proto::limits;
use gonio_store::Blobs;
use queue::Queue;
use renderer::Renderer;
use scenes::Scenes;
use std::sync::Arc;
use std::time::Duration;

/// A render pool and what it has prepared. Clones share both.
#[derive(Clone)]
pub struct Worker {
    name: String,
    queue: Queue,
    scenes: Arc<Scenes>,
    /// Where captures' files may lie besides with the coordinator.
    store: Option<Blobs>,
    /// How long what is being rendered may take to end once the worker is told to stop.
    grace: Duration,
    /// What it has done.
    meter: Arc<Meter>,
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
        let queue = Queue::new(pool);
        let meter = Arc::<Meter>::default();
        let scenes = Arc::new(Scenes::new(renderer, queue.clone(), Arc::clone(&meter)));
        Ok(Self { name: name.to_owned(), scenes, queue, store: None, grace: Duration::ZERO, meter })
    }

    /// The same worker, which looks for captures' files in `store` before it asks a remote coordinator for them.
    #[must_use]
    pub fn with_store(self, store: Blobs) -> Self {
        Self { store: Some(store), ..self }
    }

    /// The same worker, which finishes what it is rendering for up to `grace` once it is told to stop.
    #[must_use]
    pub fn with_grace(self, grace: Duration) -> Self {
        Self { grace, ..self }
    }

    /// Tasks that it renders at the same time.
    #[must_use]
    pub fn slots(&self) -> u32 {
        u32::try_from(self.queue.threads()).unwrap_or(limits::SLOTS)
    }
}
