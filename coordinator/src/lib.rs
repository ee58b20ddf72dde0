//! The coordinator of a render farm: splits evaluations into tasks, leases them to workers, reduces what comes back.
//!
//! [`Coordinator`] is the whole of it, without a transport: the [`service`] puts it behind gRPC, the `gonio` command line
//! embeds it and talks to it by channels of the same messages.

pub mod aggregate;
pub mod broker;
pub mod evaluation;
pub mod intake;
pub mod service;
pub mod split;

pub use gonio_store as store;

use broker::{Broker, Failure, ToWorker, session};
use evaluation::Captures;
use gonio_proto::convert::request::{Requester, request_from_wire};
use gonio_proto::{Digest, wire};
use intake::Intake;
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use store::{Blobs, StoreError};
use tokio::sync::Semaphore;
use tokio_stream::Stream;
use tokio_stream::wrappers::{ReceiverStream, UnboundedReceiverStream};
use tonic::Status;

/// Blobs that are received at the same time; each is held in memory until its digest is verified.
const UPLOADS: usize = 4;

/// What clients are told by a coordinator that stops.
const STOPS: &str = "the coordinator stops; ask again when it, or another, is up";

/// How long evaluations that are ended have to tell their clients.
const FAREWELL: Duration = Duration::from_secs(2);

/// A broker, its blobs, and what it read of them. Clones share all of it.
#[derive(Debug, Clone)]
pub struct Coordinator {
    /// Who works and what waits.
    pub broker: Arc<Broker>,
    /// Captures' files.
    pub blobs: Blobs,
    intake: Intake,
    captures: Arc<Captures>,
    uploads: Arc<Semaphore>,
}

impl Coordinator {
    /// A coordinator over a store, which takes workers that do not beat for `silence` for lost. Call it inside a tokio
    /// runtime, where its sweep runs until the last clone is dropped.
    #[must_use]
    pub fn new(blobs: Blobs, silence: Duration) -> Self {
        // The clock grows from one start to the next, which is all that an epoch must do.
        let epoch = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |since| since.as_millis() as u64);
        let broker = Broker::new(epoch, silence);
        tokio::spawn(Broker::keep_sweeping(Arc::downgrade(&broker), silence));
        let captures = Arc::new(Captures::new(blobs.clone()));
        Self { broker, blobs, intake: Intake::default(), captures, uploads: Arc::new(Semaphore::new(UPLOADS)) }
    }

    /// Serves one worker: what it says in, what it is told out.
    pub fn work<S>(&self, inbound: S) -> UnboundedReceiverStream<ToWorker>
    where
        S: Stream<Item = Result<wire::FromWorker, Status>> + Send + Unpin + 'static,
    {
        session::serve(Arc::clone(&self.broker), inbound)
    }

    /// Notes that a worker lives.
    ///
    /// # Errors
    /// There is no such worker: its stream has ended.
    pub fn beat(&self, worker: u64, epoch: u64) -> Result<(), Status> {
        let known = self.broker.beat(worker, epoch);
        if known { Ok(()) } else { Err(Status::not_found(format!("there is no worker {worker} of epoch {epoch}"))) }
    }

    /// Starts an evaluation; dropping the stream cancels it.
    ///
    /// # Errors
    /// A request that breaks the protocol; a coordinator that stops.
    pub fn evaluate(&self, request: wire::EvaluationRequest) -> Result<ReceiverStream<wire::EvaluationEvent>, Status> {
        let requester = Requester::of(&request)?;
        let (digest, request) = request_from_wire(request)?;
        let turn = self.intake.enter().ok_or_else(|| Status::unavailable(STOPS))?;
        Ok(evaluation::evaluate(self.clone(), turn, requester, digest, request))
    }

    /// Takes no evaluation any more, gives those that run `grace` to finish, then ends them, and all workers' streams.
    pub async fn drain(&self, grace: Duration) {
        self.intake.close();
        if tokio::time::timeout(grace, self.intake.empty()).await.is_err() {
            self.broker.fail_all(&Failure::of_farm(STOPS));
            if tokio::time::timeout(FAREWELL, self.intake.empty()).await.is_err() {
                tracing::warn!("clients that do not listen are left");
            }
        }
        self.broker.close();
        tracing::info!(counters = ?self.broker.counters(), "drained");
    }

    /// Which of these blobs are not stored.
    ///
    /// # Errors
    /// The store fails.
    pub async fn missing_blobs(&self, digests: Vec<Digest>) -> Result<Vec<Digest>, StoreError> {
        let mut missing = Vec::new();
        for digest in digests {
            if !self.blobs.has(digest).await? {
                missing.push(digest);
            }
        }
        Ok(missing)
    }
}
