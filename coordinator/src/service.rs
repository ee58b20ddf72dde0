//! The coordinator behind gRPC.
//!
//! Beside the farm, `grpc.health.v1.Health` says whether it serves: of the whole (the empty name) and of the farm's service, SERVING
//! until the coordinator is told to stop, NOT_SERVING while it drains. It asks for no token, for probes have none, and for a
//! certificate as everything does where `--client-ca` is given. One that stands by does not listen at all.

use crate::Coordinator;
use crate::broker::ToWorker;
use crate::security::{Guard, bounded};
use bytes::Bytes;
use futures::StreamExt;
use futures::stream::BoxStream;
use gonio_proto::convert::digest::{BlobAssembly, blob_chunks, digests_from_wire, digests_to_wire};
use gonio_proto::wire::farm_server::{Farm, FarmServer};
use gonio_proto::{Digest, limits, wire};
use prost::Message;
use std::future::Future;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tokio_stream::wrappers::{IntervalStream, UnboundedReceiverStream};
use tonic::transport::ServerTlsConfig;
use tonic::{Request, Response, Status, Streaming};
use tonic_health::ServingStatus;
use tonic_health::server::health_reporter;

/// How often a silent connection is asked whether it lives, and how long it may take to answer.
const KEEPALIVE: Duration = Duration::from_secs(5);

/// Connections that are open at the same time; a worker has two.
const CONNECTIONS: usize = 8192;

/// Calls under way on one connection; a sweep has some tens.
const STREAMS: u32 = 512;

/// All headers of a call.
const HEADER_BYTES: u32 = 16 << 10;

/// How often who watches is told what runs.
const JOBS: Duration = Duration::from_millis(500);

/// How long a client may take from one chunk of a blob to the next.
const CHUNK_TIMEOUT: Duration = Duration::from_secs(30);

/// How long connections have to end once the coordinator has drained; those that have not are cut.
const FAREWELL: Duration = Duration::from_secs(2);

/// Serves `coordinator` on a listener until `stop` completes, then for up to `grace` until its evaluations have ended.
///
/// # Errors
/// The transport fails.
pub async fn serve(
    coordinator: Coordinator,
    listener: TcpListener,
    stop: impl Future<Output = ()>,
    grace: Duration,
) -> Result<(), tonic::transport::Error> {
    let open = Protection { tls: None, guard: Guard::new(None) };
    serve_protected(coordinator, listener, open, stop, grace).await
}

/// What stands between a coordinator and whoever can reach its port.
#[derive(Debug, Clone)]
pub struct Protection {
    /// Encryption, and whose certificates are asked for.
    pub tls: Option<ServerTlsConfig>,
    /// What tokens allow.
    pub guard: Guard,
}

/// [`serve`], behind a protection.
///
/// # Errors
/// As [`serve`]; a certificate or key that TLS cannot use.
pub async fn serve_protected(
    coordinator: Coordinator,
    listener: TcpListener,
    protection: Protection,
    stop: impl Future<Output = ()>,
    grace: Duration,
) -> Result<(), tonic::transport::Error> {
    let farm =
        FarmServer::new(Service { coordinator: coordinator.clone() }).max_decoding_message_size(limits::MESSAGE_BYTES);
    let (health, health_server) = health_reporter();
    health.set_serving::<FarmServer<Service>>().await;
    let incoming = bounded(listener, CONNECTIONS);
    let (drains, drained) = oneshot::channel();
    let mut builder = tonic::transport::Server::builder();
    if let Some(tls) = protection.tls {
        builder = builder.tls_config(tls)?;
    }
    let server = builder
        .initial_stream_window_size(limits::STREAM_WINDOW_BYTES)
        .initial_connection_window_size(2 * limits::STREAM_WINDOW_BYTES)
        .max_frame_size(limits::FRAME_BYTES)
        .http2_keepalive_interval(Some(KEEPALIVE))
        .http2_keepalive_timeout(Some(KEEPALIVE))
        .http2_max_header_list_size(HEADER_BYTES)
        .max_concurrent_streams(STREAMS)
        .layer(protection.guard)
        .add_service(health_server)
        .add_service(farm)
        .serve_with_incoming_shutdown(incoming, async {
            // Whoever comes while it drains is told that it stops.
            let _ = drained.await;
        });
    let drain = async {
        stop.await;
        health.set_not_serving::<FarmServer<Service>>().await;
        health.set_service_status("", ServingStatus::NotServing).await;
        coordinator.drain(grace).await;
        let _ = drains.send(());
        tokio::time::sleep(FAREWELL).await;
    };
    tokio::select! {
        result = server => result,
        () = drain => Ok(()),
    }
}

struct Service {
    coordinator: Coordinator,
}

#[tonic::async_trait]
impl Farm for Service {
    type WorkStream = UnboundedReceiverStream<ToWorker>;
    type EvaluateStream = BoxStream<'static, Result<wire::EvaluationEvent, Status>>;
    type JobsStream = BoxStream<'static, Result<wire::JobList, Status>>;
    type GetBlobStream = BoxStream<'static, Result<wire::BlobChunk, Status>>;

    async fn work(&self, request: Request<Streaming<wire::FromWorker>>) -> Result<Response<Self::WorkStream>, Status> {
        Ok(Response::new(self.coordinator.work(request.into_inner())))
    }

    async fn beat(&self, request: Request<wire::Heartbeat>) -> Result<Response<wire::HeartbeatReply>, Status> {
        let wire::Heartbeat { worker, epoch } = request.into_inner();
        self.coordinator.beat(worker, epoch)?;
        Ok(Response::new(wire::HeartbeatReply {}))
    }

    async fn evaluate(
        &self,
        request: Request<wire::EvaluationRequest>,
    ) -> Result<Response<Self::EvaluateStream>, Status> {
        let caller = request.metadata().get("traceparent").and_then(|caller| caller.to_str().ok());
        let caller = caller.unwrap_or_default().to_owned();
        let events = self.coordinator.evaluate_for(request.into_inner(), &caller)?;
        let broker = Arc::clone(&self.coordinator.broker);
        let counted = move |event: wire::EvaluationEvent| {
            broker.traffic.answers.add(event.encoded_len());
            Ok(event)
        };
        Ok(Response::new(events.map(counted).boxed()))
    }

    async fn jobs(&self, _: Request<wire::JobsRequest>) -> Result<Response<Self::JobsStream>, Status> {
        let ticks = IntervalStream::new(tokio::time::interval(JOBS));
        let coordinator = self.coordinator.clone();
        Ok(Response::new(ticks.map(move |_| Ok(coordinator.list())).boxed()))
    }

    async fn cancel(&self, request: Request<wire::CancelRequest>) -> Result<Response<wire::CancelReply>, Status> {
        let cancelled = self.coordinator.cancel(request.get_ref())?;
        Ok(Response::new(wire::CancelReply { cancelled }))
    }

    async fn missing_blobs(&self, request: Request<wire::BlobDigests>) -> Result<Response<wire::BlobDigests>, Status> {
        let missing = self.coordinator.missing_blobs(digests_from_wire(request.get_ref())?).await?;
        Ok(Response::new(digests_to_wire(&missing)))
    }

    async fn put_blob(
        &self,
        request: Request<Streaming<wire::BlobChunk>>,
    ) -> Result<Response<wire::BlobReceipt>, Status> {
        let _turn = self.coordinator.uploads.acquire().await.map_err(|e| Status::unavailable(e.to_string()))?;
        let mut chunks = request.into_inner();
        let mut assembly = BlobAssembly::default();
        loop {
            let chunk = tokio::time::timeout(CHUNK_TIMEOUT, chunks.message()).await;
            match chunk.map_err(|_| Status::deadline_exceeded("no further chunk of the blob came"))?? {
                Some(chunk) => {
                    self.coordinator.broker.traffic.uploads.add(chunk.data.len());
                    assembly.add(&chunk)?;
                }
                None => break,
            }
        }
        let verified = tokio::task::spawn_blocking(move || assembly.finish()).await;
        let (digest, blob) = verified.map_err(|error| Status::internal(error.to_string()))??;
        let existed = self.coordinator.blobs.put(digest, blob).await?;
        Ok(Response::new(wire::BlobReceipt { existed }))
    }

    async fn get_blob(&self, request: Request<wire::BlobDigest>) -> Result<Response<Self::GetBlobStream>, Status> {
        let digest = Digest::from_wire("BlobDigest.digest", &request.get_ref().digest)?;
        let blob: Bytes = self.coordinator.blobs.get(digest, limits::BLOB_BYTES).await?;
        let broker = Arc::clone(&self.coordinator.broker);
        let counted = move |chunk: wire::BlobChunk| {
            broker.traffic.downloads.add(chunk.data.len());
            Ok(chunk)
        };
        Ok(Response::new(futures::stream::iter(blob_chunks(digest, blob).map(counted)).boxed()))
    }
}
