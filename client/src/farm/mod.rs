//! The farm as a client sees it: in this process or behind a URL, by the same messages, broker and commit path.

mod link;
mod open;

pub use gonio_proto::convert::job::Job;
pub use gonio_worker::access::Access;
pub use open::OpenCapture;

use crate::input::Input;
use futures::StreamExt;
use gonio_coordinator::store::Blobs;
use gonio_coordinator::{Coordinator, broker};
use gonio_proto::convert::manifest::pack;
use gonio_proto::convert::request::{Class, Requester};
use gonio_proto::{Digest, limits, wire};
use gonio_scene::SceneError;
use gonio_scene::files::Files;
use gonio_worker::Worker;
use gonio_worker::access::AccessError;
use gonio_worker::renderer::{PathTracer, Renderer};
use link::Link;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::runtime::Runtime;
use tonic::Status;

/// Why there is no farm, or why a capture cannot be sent to it.
#[derive(Debug, thiserror::Error)]
pub enum FarmError {
    /// Threads could not be started.
    #[error("cannot start the render threads: {0}; ask for fewer with --threads")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The runtime could not be started.
    #[error("cannot start: {0}")]
    Runtime(#[from] std::io::Error),
    /// The coordinator cannot be asked at all.
    #[error("--farm {0}")]
    Access(#[from] AccessError),
    /// The capture is at fault.
    #[error(transparent)]
    Capture(#[from] SceneError),
    /// A file changed between being listed and being sent.
    #[error("{0}: changed while it was being sent; try again when nobody writes to it")]
    Changed(String),
    /// The farm refuses or cannot be reached.
    #[error("the farm: {}", gonio_worker::remote::text(.0))]
    Farm(#[from] Status),
}

/// What runs on a farm.
#[derive(Debug, Clone)]
pub struct Jobs {
    /// Evaluations, in the order in which they came.
    pub jobs: Vec<Job>,
    /// Workers connected.
    pub workers: u32,
    /// Tasks that they render at the same time.
    pub slots: u64,
}

/// A farm. Clones share it.
#[derive(Clone)]
pub struct Farm {
    shared: Arc<Shared>,
    /// Whose evaluations are sent by this clone.
    requester: Requester,
}

struct Shared {
    /// Runs the messages. Dropped with the last clone, it waits for what is being reduced, not for what is being rendered.
    runtime: Runtime,
    link: Link,
}

impl Farm {
    fn new(runtime: Runtime, link: Link) -> Self {
        // Another process may have the same number on another machine, but hardly from the same nanosecond.
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let client = format!("{}-{:x}", std::process::id(), since.as_nanos());
        let requester = Requester { client, class: Class::Interactive };
        Self { shared: Arc::new(Shared { runtime, link }), requester }
    }

    /// The same farm for evaluations that nobody waits for, such as a sweep's: together they get a smaller share of it
    /// while somebody else's fit runs.
    #[must_use]
    pub fn for_batches(mut self) -> Self {
        self.requester.class = Class::Batch;
        self
    }

    /// The same farm, whose list of jobs names this client by what it does.
    #[must_use]
    pub fn named(mut self, what: &str) -> Self {
        self.requester.client = format!("{what}-{}", self.requester.client);
        self
    }

    /// A farm inside this process, of `threads` render threads (0: one per core).
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn embedded(threads: usize) -> Result<Self, FarmError> {
        Self::embedded_with(threads, Arc::new(PathTracer))
    }

    /// An embedded farm that renders with something else than the path tracer.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn embedded_with(threads: usize, renderer: Arc<dyn Renderer>) -> Result<Self, FarmError> {
        let runtime = runtime()?;
        let worker = Worker::new("embedded", threads, renderer)?;
        let coordinator = {
            let _inside = runtime.enter();
            Coordinator::new(Blobs::in_memory(), broker::SILENCE)
        };
        runtime.spawn(link::work_embedded(worker, coordinator.clone()));
        Ok(Self::new(runtime, Link::Embedded(coordinator)))
    }

    /// The farm whose coordinator listens at `url`.
    ///
    /// # Errors
    /// No URL, or nobody answers there.
    pub fn connect(url: &str) -> Result<Self, FarmError> {
        Self::connect_by(url, &Access::default())
    }

    /// The farm whose coordinator listens at `url` and asks who connects.
    ///
    /// # Errors
    /// As [`Farm::connect`]; a certificate or token that cannot be read, or is refused.
    pub fn connect_by(url: &str, access: &Access) -> Result<Self, FarmError> {
        let runtime = runtime()?;
        let link = {
            let _inside = runtime.enter();
            Link::Remote(access.client(url)?)
        };
        let farm = Self::new(runtime, link);
        farm.block_on(farm.shared.link.missing(&[]))?;
        Ok(farm)
    }

    /// Sends what the farm does not have yet of a capture. Each file travels once, however often it is opened.
    ///
    /// # Errors
    /// A capture that is broken or cannot be read; a farm that cannot be reached.
    pub fn open(&self, files: &dyn Files) -> Result<OpenCapture, FarmError> {
        self.send(files, &|_, _, _| false)
    }

    /// As [`Farm::open`], but an embedded farm reads the files on disk where they lie, whenever it needs them, and holds none of them:
    /// the photographs of a capture may be larger than memory.
    ///
    /// # Errors
    /// As [`Farm::open`].
    pub fn open_input(&self, input: &Input) -> Result<OpenCapture, FarmError> {
        let lend =
            |path: &str, digest, size| !input.holds(path) && self.shared.link.lend(&input.files, path, digest, size);
        self.send(input, &lend)
    }

    /// Whether its coordinator is another process.
    #[must_use]
    pub fn is_remote(&self) -> bool {
        self.shared.link.is_remote()
    }

    /// Sends what the farm lacks and `lend` does not show it.
    fn send(&self, files: &dyn Files, lend: &dyn Fn(&str, Digest, u64) -> bool) -> Result<OpenCapture, FarmError> {
        let packed = pack(files)?;
        let manifest = packed.manifest.to_blob();
        let capture = Digest::of(&manifest);
        let mut by_digest: Vec<(Digest, &str)> =
            packed.manifest.files.iter().map(|(path, (digest, _))| (*digest, path.as_str())).collect();
        by_digest.retain(|(digest, path)| !lend(path, *digest, packed.manifest.files[*path].1));
        by_digest.sort_unstable();
        by_digest.dedup_by_key(|(digest, _)| *digest);
        let digests: Vec<Digest> = by_digest.iter().map(|(digest, _)| *digest).collect();
        for digests in digests.chunks(limits::DIGESTS) {
            for digest in self.block_on(self.shared.link.missing(digests))? {
                let Ok(found) = by_digest.binary_search_by_key(&digest, |(digest, _)| *digest) else { continue };
                let path = by_digest[found].1;
                let bytes = files.read(path)?;
                if Digest::of(&bytes) != digest {
                    return Err(FarmError::Changed(path.to_owned()));
                }
                self.block_on(self.shared.link.put(digest, bytes::Bytes::from_owner(bytes)))?;
            }
        }
        // Last, so that a capture that is there is there with all its files.
        self.block_on(self.shared.link.put(capture, manifest))?;
        Ok(OpenCapture::new(self.clone(), capture, packed))
    }

    /// What runs on the farm: calls `seen` with it, and about twice a second again for as long as that says to go on.
    ///
    /// # Errors
    /// The farm cannot be reached, or breaks the protocol.
    pub fn jobs(&self, seen: &mut dyn FnMut(Jobs) -> ControlFlow<()>) -> Result<(), FarmError> {
        self.block_on(async {
            let mut lists = self.shared.link.jobs().await?;
            while let Some(list) = lists.next().await {
                let list = list?;
                let jobs: Result<_, _> = list.jobs.iter().map(Job::from_wire).collect();
                let jobs = Jobs { jobs: jobs.map_err(Status::from)?, workers: list.workers, slots: list.slots };
                if seen(jobs).is_break() {
                    break;
                }
            }
            Ok(())
        })
    }

    /// Ends what a client has under way; returns how many evaluations that were.
    ///
    /// # Errors
    /// The farm cannot be reached, or refuses.
    pub fn cancel(&self, client: &str) -> Result<u32, FarmError> {
        let request = wire::CancelRequest { key: bytes::Bytes::new(), client: client.to_owned() };
        Ok(self.block_on(self.shared.link.cancel(request))?)
    }

    /// Sends a blob that belongs to no capture.
    fn put(&self, digest: Digest, blob: bytes::Bytes) -> Result<(), FarmError> {
        Ok(self.block_on(self.shared.link.put(digest, blob))?)
    }

    fn block_on<T>(&self, future: impl Future<Output = T>) -> T {
        self.shared.runtime.block_on(future)
    }
}

fn runtime() -> std::io::Result<Runtime> {
    tokio::runtime::Builder::new_multi_thread().worker_threads(2).thread_name("farm").enable_all().build()
}
