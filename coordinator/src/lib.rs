//! The coordinator of a render farm: splits evaluations into tasks, leases them to workers, reduces what comes back.
//!
//! [`Coordinator`] is the whole of it, without a transport: the [`service`] puts it behind gRPC, the `gonio` command line
//! embeds it and talks to it by channels of the same messages.

pub mod aggregate;
pub mod broker;
pub mod evaluation;
pub mod intake;
pub mod jobs;
pub mod journal;
pub mod operations;
pub mod page;
pub mod scaler;
pub mod security;
pub mod service;
pub mod split;

pub use gonio_store as store;

use broker::{Broker, Failure, ToWorker, session};
use evaluation::Captures;
use gonio_proto::convert::event::CANCELLED;
use gonio_proto::convert::job::Job;
use gonio_proto::{Digest, Key, wire};
use intake::Intake;
use jobs::Jobs;
use journal::{ClaimError, Journal};
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
    /// What runs.
    pub jobs: Jobs,
    /// Where it is written down, if it is to outlive this coordinator.
    journal: Option<Journal>,
    intake: Intake,
    captures: Arc<Captures>,
    uploads: Arc<Semaphore>,
}

impl Coordinator {
    /// A coordinator over a store, which takes workers that do not beat for `silence` for lost. What it runs ends with it. Call
    /// it inside a tokio runtime, where its sweep runs until the last clone is dropped.
    #[must_use]
    pub fn new(blobs: Blobs, silence: Duration) -> Self {
        // The clock grows from one start to the next, which is all that an epoch must do.
        let epoch = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |since| since.as_millis() as u64);
        Self::with(blobs, silence, epoch, None)
    }

    /// The coordinator that owns the farm of a store: it goes on with what an earlier one has left there, and leaves there
    /// what it runs itself. Blobs must be in the same store.
    ///
    /// # Errors
    /// The store fails, or its journal is damaged.
    pub async fn durable(blobs: Blobs, silence: Duration) -> Result<Self, ClaimError> {
        let (journal, restored) = journal::open(&blobs).await?;
        let coordinator = Self::with(blobs, silence, journal.epoch(), Some(journal));
        for evaluation in restored {
            evaluation::resume(&coordinator, evaluation);
        }
        Ok(coordinator)
    }

    fn with(blobs: Blobs, silence: Duration, epoch: u64, journal: Option<Journal>) -> Self {
        let broker = Broker::new(epoch, silence);
        tokio::spawn(Broker::keep_sweeping(Arc::downgrade(&broker), silence));
        let captures = Arc::new(Captures::new(blobs.clone()));
        let uploads = Arc::new(Semaphore::new(UPLOADS));
        Self { broker, blobs, jobs: Jobs::default(), journal, intake: Intake::default(), captures, uploads }
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

    /// Starts an evaluation, or listens to the one with the same key. Dropping the stream cancels one without a key.
    ///
    /// # Errors
    /// A request that breaks the protocol; a coordinator that stops.
    pub fn evaluate(&self, request: wire::EvaluationRequest) -> Result<ReceiverStream<wire::EvaluationEvent>, Status> {
        self.evaluate_for(request, &gonio_operations::trace_parent())
    }

    /// [`Self::evaluate`] for a caller elsewhere, whose span `caller` names as a W3C traceparent; it may be empty.
    ///
    /// # Errors
    /// As [`Self::evaluate`].
    pub fn evaluate_for(
        &self,
        request: wire::EvaluationRequest,
        caller: &str,
    ) -> Result<ReceiverStream<wire::EvaluationEvent>, Status> {
        evaluation::evaluate(self.clone(), request, caller)
    }

    /// What runs.
    #[must_use]
    pub fn list(&self) -> wire::JobList {
        let job = |job: Arc<jobs::Job>| {
            let progress = evaluation::progress(self, &job);
            let listeners = u32::try_from(job.listeners()).unwrap_or(u32::MAX);
            let (requester, age) = (job.requester.clone(), job.since.elapsed());
            Job { key: job.key, requester, capture: job.capture, progress, listeners, age }.to_wire()
        };
        let (workers, slots) = self.broker.strength();
        wire::JobList { jobs: self.jobs.all().into_iter().map(job).collect(), workers, slots }
    }

    /// Ends the evaluation with a key, or all of a client; returns how many.
    ///
    /// # Errors
    /// A key that is none, or neither key nor client.
    pub fn cancel(&self, request: &wire::CancelRequest) -> Result<u32, Status> {
        let key = Key::from_wire("CancelRequest.key", &request.key)?;
        if key.is_none() && request.client.is_empty() {
            return Err(Status::invalid_argument("CancelRequest: names neither a key nor a client"));
        }
        Ok(self.jobs.cancel(key, &request.client, CANCELLED))
    }

    /// Completes when this coordinator does not own its farm any more, with the reason; never for one that is not durable.
    pub async fn lost(&self) -> String {
        match &self.journal {
            Some(journal) => journal.lost().await,
            None => std::future::pending().await,
        }
    }

    /// Whether this coordinator does not own its farm any more.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.journal.as_ref().is_some_and(Journal::is_lost)
    }

    /// Takes no evaluation any more, gives those that run `grace` to finish, then ends them, and all workers' streams. What
    /// is written down is left to the next coordinator instead.
    pub async fn drain(&self, grace: Duration) {
        self.intake.close();
        // Whoever does not own the farm has nothing to finish.
        let grace = if self.is_lost() { Duration::ZERO } else { grace };
        if tokio::time::timeout(grace, self.intake.empty()).await.is_err() {
            if self.journal.is_some() {
                self.intake.leave();
            }
            self.broker.fail_all(&Failure::of_farm(STOPS));
            if tokio::time::timeout(FAREWELL, self.intake.empty()).await.is_err() {
                tracing::warn!("clients that do not listen are left");
            }
        }
        self.broker.close();
        if let Some(journal) = &self.journal {
            journal.release().await;
        }
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
