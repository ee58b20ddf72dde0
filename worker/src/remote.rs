//! A coordinator in another process.

use crate::access::{Access, AccessError, Client};
use crate::heart::Heart;
use crate::pull::{Link, PullError};
use crate::source::StoreFirst;
use crate::{BlobSource, Worker};
use backon::BackoffBuilder;
use bytes::Bytes;
use futures::future::BoxFuture;
use futures::{FutureExt, StreamExt};
use gonio_proto::convert::digest::BlobAssembly;
use gonio_proto::{Digest, wire};
use std::future::Future;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Code, Status};

/// Messages that wait to be sent; each at most a chunk of a film.
const OUTBOUND: usize = 16;

/// A stream that lasted this long was a good one: the next reconnection starts without a wait.
const GOOD_STREAM: Duration = Duration::from_secs(10);

/// Fetches blobs from a coordinator.
struct RemoteBlobs(Client);

impl BlobSource for RemoteBlobs {
    fn get(&self, digest: Digest) -> BoxFuture<'_, Result<Bytes, String>> {
        let mut client = self.0.clone();
        async move {
            let request = wire::BlobDigest { digest: digest.to_wire() };
            let mut chunks = client.get_blob(request).await.map_err(|status| text(&status))?.into_inner();
            let mut assembly = BlobAssembly::default();
            while let Some(chunk) = chunks.message().await.map_err(|status| text(&status))? {
                assembly.add(&chunk).map_err(|error| error.to_string())?;
            }
            let blob =
                tokio::task::spawn_blocking(move || assembly.finish()).await.map_err(|error| error.to_string())?;
            match blob.map_err(|error| error.to_string())? {
                (found, blob) if found == digest => Ok(blob),
                (found, _) => Err(format!("asked for blob {digest}, {found} came")),
            }
        }
        .boxed()
    }
}

/// Beats over a connection of its own.
struct RemoteHeart(Client);

impl Heart for RemoteHeart {
    fn beat(&self, worker: u64, epoch: u64) -> BoxFuture<'_, Result<(), Status>> {
        let mut client = self.0.clone();
        async move { client.beat(wire::Heartbeat { worker, epoch }).await.map(|_| ()) }.boxed()
    }
}

/// A status for people.
#[must_use]
pub fn text(status: &Status) -> String {
    format!("{} ({})", status.message(), status.code())
}

impl Worker {
    /// Works for the coordinator at `url`, reached by `access`, until `stop` completes; connects again, ever less often up to
    /// every ten seconds, when a stream ends.
    ///
    /// # Errors
    /// No URL, or no usable access; a coordinator that will never take this worker, such as one of another version.
    pub async fn work_for(&self, url: &str, access: &Access, stop: impl Future<Output = ()>) -> Result<(), WorkError> {
        self.meter.pulse.beside(self.connect_and_serve(url, access, stop)).await
    }

    async fn connect_and_serve(
        &self,
        url: &str,
        access: &Access,
        stop: impl Future<Output = ()>,
    ) -> Result<(), WorkError> {
        let client = access.client(url)?;
        // On the connection of the films a beat would wait behind megabytes, wherever the network is slow.
        let heart: Arc<dyn Heart> = Arc::new(RemoteHeart(access.client(url)?));
        let fresh = || {
            let builder = backon::ExponentialBuilder::default().with_jitter().without_max_times();
            builder.with_min_delay(Duration::from_millis(100)).with_max_delay(Duration::from_secs(10)).build()
        };
        let mut waits = fresh();
        let stop = stop.shared();
        loop {
            let started = Instant::now();
            self.meter.connections.fetch_add(1, Ordering::Relaxed);
            let end = tokio::select! {
                link = self.connect(client.clone(), Arc::clone(&heart)) => match link {
                    Ok(link) => {
                        tracing::info!(url, "connected");
                        match self.serve(link, stop.clone()).await {
                            Ok(()) => return Ok(()),
                            Err(PullError::Ended(status)) => status,
                            Err(error) => return Err(error.into()),
                        }
                    }
                    Err(status) => status,
                },
                () = stop.clone() => return Ok(()),
            };
            if matches!(
                end.code(),
                Code::FailedPrecondition | Code::InvalidArgument | Code::PermissionDenied | Code::Unauthenticated
            ) {
                return Err(WorkError::Refused(text(&end)));
            }
            if started.elapsed() > GOOD_STREAM {
                waits = fresh();
            }
            let wait = waits.next().unwrap_or(Duration::from_secs(10));
            tracing::warn!(url, reason = text(&end), ?wait, "no connection, trying again");
            tokio::select! {
                () = tokio::time::sleep(wait) => {}
                () = stop.clone() => return Ok(()),
            }
        }
    }

    async fn connect(&self, mut client: Client, heart: Arc<dyn Heart>) -> Result<Link, Status> {
        let (outbound, receiver) = mpsc::channel(OUTBOUND);
        let inbound = client.work(ReceiverStream::new(receiver)).await?.into_inner().boxed();
        let coordinator = RemoteBlobs(client);
        let blobs: Arc<dyn BlobSource> = match &self.store {
            Some(store) => Arc::new(StoreFirst { store: store.clone(), otherwise: coordinator }),
            None => Arc::new(coordinator),
        };
        Ok(Link { outbound, inbound, blobs, heart })
    }
}

/// Why a worker gives up.
#[derive(Debug, thiserror::Error)]
pub enum WorkError {
    /// The coordinator cannot be asked at all.
    #[error(transparent)]
    Access(#[from] AccessError),
    /// The coordinator will not take this worker.
    #[error("the coordinator refuses this worker: {0}")]
    Refused(String),
    /// The coordinator speaks another protocol.
    #[error(transparent)]
    Pull(#[from] PullError),
}
