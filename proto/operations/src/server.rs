//! The port behind which probes and metrics are.

use crate::{Probe, Verdict};
use axum::Router;
use axum::extract::State;
use axum::http::{StatusCode, header::CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use std::{io, thread};
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

/// Connections that are open at the same time; more wait. Each serves one request.
const CONNECTIONS: usize = 64;

/// How long one may take, from its beginning to its end.
const PATIENCE: Duration = Duration::from_secs(10);

type Shared = State<Arc<dyn Probe>>;

/// Answers for `probe` at `address`, on a thread of its own, for as long as the process lives; returns the address with the
/// port that it has.
///
/// # Errors
/// The address cannot be listened on, or there is no thread to be had.
pub fn serve(address: SocketAddr, probe: Arc<dyn Probe>) -> io::Result<SocketAddr> {
    let listener = std::net::TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    let bound = listener.local_addr()?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let routes = Router::new()
        .route("/healthz/startup", get(|State(probe): Shared| async move { answer(probe.startup()) }))
        .route("/healthz/ready", get(|State(probe): Shared| async move { answer(probe.ready()) }))
        .route("/healthz/live", get(|State(probe): Shared| async move { answer(probe.live()) }))
        .route("/metrics", get(metrics))
        .with_state(probe);
    thread::Builder::new().name("operations".to_owned()).spawn(move || {
        runtime.block_on(async move {
            match TcpListener::from_std(listener) {
                Ok(listener) => accept(listener, routes).await,
                Err(error) => tracing::error!(%error, "nobody answers at --operations"),
            }
        });
    })?;
    Ok(bound)
}

async fn accept(listener: TcpListener, routes: Router) {
    let places = Arc::new(Semaphore::new(CONNECTIONS));
    loop {
        let Ok(place) = Arc::clone(&places).acquire_owned().await else { return };
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(error) => {
                // Such as no file descriptor left: others must be closed first.
                tracing::warn!(%error, "a connection to --operations is not taken");
                tokio::time::sleep(Duration::from_millis(100)).await;
                continue;
            }
        };
        let service = TowerToHyperService::new(routes.clone());
        let mut http = hyper::server::conn::http1::Builder::new();
        http.timer(TokioTimer::new()).keep_alive(false);
        tokio::spawn(async move {
            let connection = http.serve_connection(TokioIo::new(stream), service);
            // Who calls and goes, or says nothing, is no matter for the log.
            let _ = tokio::time::timeout(PATIENCE, connection).await;
            drop(place);
        });
    }
}

fn answer(verdict: Verdict) -> Response {
    match verdict {
        Ok(()) => (StatusCode::OK, "ok\n").into_response(),
        Err(why) => (StatusCode::SERVICE_UNAVAILABLE, why + "\n").into_response(),
    }
}

/// Metrics are counted under locks: should one never come free, the probes must still be answered.
async fn metrics(State(probe): Shared) -> Response {
    let text = tokio::task::spawn_blocking(move || probe.metrics().text()).await;
    match text {
        Ok(Ok(text)) => ([(CONTENT_TYPE, prometheus::TEXT_FORMAT)], text).into_response(),
        Ok(Err(error)) => (StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")).into_response(),
    }
}
