//! How a client's calls reach a coordinator.

use futures::FutureExt;
use futures::StreamExt;
use futures::future::BoxFuture;
use futures::stream::BoxStream;
use gonio_coordinator::Coordinator;
use gonio_proto::convert::digest::{blob_chunks, digests_from_wire, digests_to_wire};
use gonio_proto::{Digest, wire};
use gonio_scene::files::{DirectoryFiles, Files};
use gonio_worker::access::Client;
use gonio_worker::pull::Link as WorkerLink;
use gonio_worker::{Heart, Worker};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Status;
use tonic::metadata::MetadataValue;

/// What an evaluation streams back.
pub(super) type Events = BoxStream<'static, Result<wire::EvaluationEvent, Status>>;

/// A coordinator in this process or in another.
pub(super) enum Link {
    /// Called directly; its messages are never encoded.
    Embedded(Coordinator),
    /// Called by gRPC.
    Remote(Client),
}

impl Link {
    pub async fn missing(&self, digests: &[Digest]) -> Result<Vec<Digest>, Status> {
        match self {
            Self::Embedded(coordinator) => Ok(coordinator.missing_blobs(digests.to_vec()).await?),
            Self::Remote(client) => {
                let missing = client.clone().missing_blobs(digests_to_wire(digests)).await?;
                Ok(digests_from_wire(missing.get_ref())?)
            }
        }
    }

    pub async fn put(&self, digest: Digest, blob: bytes::Bytes) -> Result<(), Status> {
        match self {
            Self::Embedded(coordinator) => {
                coordinator.blobs.put(digest, blob).await?;
            }
            Self::Remote(client) => {
                client.clone().put_blob(futures::stream::iter(blob_chunks(digest, blob))).await?;
            }
        }
        Ok(())
    }

    /// Shows a coordinator in this process where a file lies; false where it is in another.
    pub fn lend(&self, files: &DirectoryFiles, path: &str, digest: Digest, size: u64) -> bool {
        let Self::Embedded(coordinator) = self else { return false };
        let (files, path) = (files.clone(), path.to_owned());
        let read = move || files.read(&path).map(bytes::Bytes::from_owner).map_err(|error| error.to_string());
        coordinator.blobs.lend(digest, size, read);
        true
    }

    pub async fn evaluate(&self, request: wire::EvaluationRequest) -> Result<Events, Status> {
        match self {
            Self::Embedded(coordinator) => Ok(coordinator.evaluate(request)?.map(Ok).boxed()),
            Self::Remote(client) => {
                let mut request = tonic::Request::new(request);
                if let Ok(caller) = gonio_operations::trace_parent().parse::<MetadataValue<_>>()
                    && !caller.is_empty()
                {
                    request.metadata_mut().insert("traceparent", caller);
                }
                Ok(client.clone().evaluate(request).await?.into_inner().boxed())
            }
        }
    }
}

impl Link {
    /// Whether the coordinator is another process, which may go away and come back.
    pub fn is_remote(&self) -> bool {
        matches!(self, Self::Remote(_))
    }

    pub async fn jobs(&self) -> Result<BoxStream<'static, Result<wire::JobList, Status>>, Status> {
        match self {
            Self::Embedded(coordinator) => Ok(futures::stream::iter([Ok(coordinator.list())]).boxed()),
            Self::Remote(client) => Ok(client.clone().jobs(wire::JobsRequest {}).await?.into_inner().boxed()),
        }
    }

    pub async fn cancel(&self, request: wire::CancelRequest) -> Result<u32, Status> {
        match self {
            Self::Embedded(coordinator) => coordinator.cancel(&request),
            Self::Remote(client) => Ok(client.clone().cancel(request).await?.into_inner().cancelled),
        }
    }
}

/// Beats by a call.
struct EmbeddedHeart(Coordinator);

impl Heart for EmbeddedHeart {
    fn beat(&self, worker: u64, epoch: u64) -> BoxFuture<'_, Result<(), Status>> {
        let beaten = self.0.beat(worker, epoch);
        async move { beaten }.boxed()
    }
}

/// Works for an embedded coordinator, for as long as its runtime lives.
pub(super) async fn work_embedded(worker: Worker, coordinator: Coordinator) {
    loop {
        let (outbound, receiver) = mpsc::channel(2 * worker.slots() as usize);
        let inbound = coordinator.work(ReceiverStream::new(receiver).map(Ok)).boxed();
        let blobs = Arc::new(coordinator.blobs.clone());
        let heart = Arc::new(EmbeddedHeart(coordinator.clone()));
        let link = WorkerLink { outbound, inbound, blobs, heart };
        if let Err(error) = worker.serve(link, std::future::pending()).await {
            tracing::error!(%error, "the embedded worker starts again");
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    }
}
