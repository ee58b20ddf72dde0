//! The coordinator of a render farm: splits evaluations into tasks, leases them to workers, reduces what comes back.
//!
//! [`Coordinator`] is the whole of it, without a transport: the [`service`] puts it behind gRPC, the `gonio` command line
//! embeds it and talks to it by channels of the same messages.

pub mod aggregate;
pub mod broker;
pub mod evaluation;
pub mod service;
pub mod split;

pub use gonio_store as store;

use broker::{Broker, ToWorker, session};
use evaluation::Captures;
use gonio_proto::convert::request::request_from_wire;
use gonio_proto::{Digest, WireError, wire};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use store::{Blobs, StoreError};
use tokio::sync::Semaphore;
use tokio_stream::Stream;
use tokio_stream::wrappers::{ReceiverStream, UnboundedReceiverStream};
use tonic::Status;

/// Blobs that are received at the same time; each is held in memory until its digest is verified.
const UPLOADS: usize = 4;

/// A broker, its blobs, and what it read of them. Clones share all of it.
#[derive(Debug, Clone)]
pub struct Coordinator {
    /// Who works and what waits.
    pub broker: Arc<Broker>,
    /// Captures' files.
    pub blobs: Blobs,
    captures: Arc<Captures>,
    uploads: Arc<Semaphore>,
}

impl Coordinator {
    /// A coordinator over a store, whose leases last for `lease`. Call it inside a tokio runtime, where its sweep runs
    /// until the last clone is dropped.
    #[must_use]
    pub fn new(blobs: Blobs, lease: Duration) -> Self {
        // The clock grows from one start to the next, which is all that an epoch must do.
        let epoch = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |since| since.as_millis() as u64);
        let broker = Broker::new(epoch, lease);
        tokio::spawn(Broker::keep_sweeping(Arc::downgrade(&broker), lease));
        let captures = Arc::new(Captures::new(blobs.clone()));
        Self { broker, blobs, captures, uploads: Arc::new(Semaphore::new(UPLOADS)) }
    }

    /// Serves one worker: what it says in, what it is told out.
    pub fn work<S>(&self, inbound: S) -> UnboundedReceiverStream<ToWorker>
    where
        S: Stream<Item = Result<wire::FromWorker, Status>> + Send + Unpin + 'static,
    {
        session::serve(Arc::clone(&self.broker), inbound)
    }

    /// Starts an evaluation; dropping the stream cancels it.
    ///
    /// # Errors
    /// A request that breaks the protocol.
    pub fn evaluate(
        &self,
        request: wire::EvaluationRequest,
    ) -> Result<ReceiverStream<wire::EvaluationEvent>, WireError> {
        let (digest, request) = request_from_wire(request)?;
        Ok(evaluation::evaluate(self.clone(), digest, request))
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
