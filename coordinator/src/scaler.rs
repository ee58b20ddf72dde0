//! Tells KEDA how many workers there is work for, as its external scaler.
//!
//! KEDA shows no bearer token, so that this has a port of its own, which certificates protect as they do the farm's: a client of
//! it sees two numbers that the role `watch` would let it see, and can change nothing. In a ScaledObject, the trigger is of
//! the type `external-push` (or `external`), and its metadata is
//!
//! | key | value |
//! | --- | --- |
//! | `scalerAddress` | HOST:PORT of `--scaler`; the coordinator's certificate must name HOST |
//! | `slots` | tasks that a worker should have in hand, at least 1: its `--threads`, or more where tasks are short |
//!
//! and its TriggerAuthentication gives `caCert`, `tlsClientCert` and `tlsClientKey`, a member's. The metric is (queued + leased)
//! / slots, workers that there is work for, of which each replica should have one.

use crate::Coordinator;
use crate::broker::Load;
use futures::StreamExt;
use futures::stream::BoxStream;
use gonio_proto::scaler::external_scaler_server::{ExternalScaler, ExternalScalerServer};
use gonio_proto::scaler::{
    GetMetricSpecResponse, GetMetricsRequest, GetMetricsResponse, IsActiveResponse, MetricSpec, MetricValue,
    ScaledObjectRef,
};
use std::future::{pending, ready};
use std::io;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio_stream::wrappers::IntervalStream;
use tonic::transport::ServerTlsConfig;
use tonic::{Request, Response, Status};

/// The metric's name.
pub const METRIC: &str = "gonio-workers-wanted";

/// The key of a trigger's metadata that says how many tasks a worker should have in hand.
const SLOTS: &str = "slots";

/// How often it is looked whether there is work: the longest that KEDA waits for the news.
const LOOK: Duration = Duration::from_millis(500);

/// Connections that are open at the same time; KEDA has one or two.
const CONNECTIONS: usize = 32;

/// Calls under way on one connection.
const STREAMS: u32 = 64;

/// A port that has been opened.
pub struct Port {
    listener: TcpListener,
    tls: Option<ServerTlsConfig>,
}

impl Port {
    /// Listens, and says where.
    ///
    /// # Errors
    /// The address cannot be listened on.
    pub async fn open(address: SocketAddr, tls: Option<ServerTlsConfig>) -> io::Result<Self> {
        let named = |error: io::Error| {
            io::Error::new(error.kind(), format!("--scaler {address}: {error}; choose another address"))
        };
        let listener = TcpListener::bind(address).await.map_err(named)?;
        let scheme = if tls.is_some() { "https" } else { "http" };
        println!("scaler on {scheme}://{}", listener.local_addr()?);
        Ok(Self { listener, tls })
    }
}

/// Answers KEDA, for ever; without a port, does nothing for ever.
///
/// # Errors
/// The transport fails; a certificate or key that TLS cannot use.
pub async fn serve(coordinator: Coordinator, port: Option<Port>) -> Result<(), tonic::transport::Error> {
    let Some(Port { listener, tls }) = port else { return pending().await };
    let mut builder = tonic::transport::Server::builder();
    if let Some(tls) = tls {
        builder = builder.tls_config(tls)?;
    }
    builder
        .max_concurrent_streams(STREAMS)
        .add_service(ExternalScalerServer::new(Scaler { coordinator }))
        .serve_with_incoming(crate::security::bounded(listener, CONNECTIONS))
        .await
}

struct Scaler {
    coordinator: Coordinator,
}

/// Tasks that a worker of this trigger should have in hand.
fn slots(trigger: &ScaledObjectRef) -> Result<u32, Status> {
    let name = gonio_proto::convert::text(&trigger.name);
    let given = trigger.scaler_metadata.get(SLOTS).ok_or_else(|| {
        let text = format!("ScaledObject {name}: the trigger's metadata has no {SLOTS}; write how many tasks a worker should have in hand");
        Status::invalid_argument(text)
    })?;
    given.parse::<u32>().ok().filter(|slots| *slots > 0).ok_or_else(|| {
        let given = gonio_proto::convert::text(given);
        Status::invalid_argument(format!("ScaledObject {name}: {SLOTS} is {given:?}; write a whole number from 1 on"))
    })
}

/// Workers that there is work for, as the number and rounded up.
#[allow(clippy::cast_precision_loss)]
fn wanted(load: Load, slots: u32) -> (f64, i64) {
    let whole = load.tasks().div_ceil(slots.into());
    (load.tasks() as f64 / f64::from(slots), i64::try_from(whole).unwrap_or(i64::MAX))
}

#[tonic::async_trait]
impl ExternalScaler for Scaler {
    type StreamIsActiveStream = BoxStream<'static, Result<IsActiveResponse, Status>>;

    async fn is_active(&self, request: Request<ScaledObjectRef>) -> Result<Response<IsActiveResponse>, Status> {
        slots(request.get_ref())?;
        Ok(Response::new(IsActiveResponse { result: self.coordinator.broker.load().tasks() > 0 }))
    }

    async fn stream_is_active(
        &self,
        request: Request<ScaledObjectRef>,
    ) -> Result<Response<Self::StreamIsActiveStream>, Status> {
        slots(request.get_ref())?;
        let ticks = IntervalStream::new(tokio::time::interval(LOOK));
        let (looked, closed) = (self.coordinator.clone(), self.coordinator.clone());
        let mut last = None;
        let changes = ticks.filter_map(move |_| {
            let active = looked.broker.load().tasks() > 0;
            let changed = last.replace(active) != Some(active);
            ready(changed.then_some(Ok(IsActiveResponse { result: active })))
        });
        // KEDA comes back to whoever owns the farm by then.
        let stops = async move { closed.broker.closed().await };
        Ok(Response::new(changes.take_until(Box::pin(stops)).boxed()))
    }

    async fn get_metric_spec(
        &self,
        request: Request<ScaledObjectRef>,
    ) -> Result<Response<GetMetricSpecResponse>, Status> {
        slots(request.get_ref())?;
        let spec = MetricSpec { metric_name: METRIC.to_owned(), target_size: 1, target_size_float: 1.0 };
        Ok(Response::new(GetMetricSpecResponse { metric_specs: vec![spec] }))
    }

    async fn get_metrics(&self, request: Request<GetMetricsRequest>) -> Result<Response<GetMetricsResponse>, Status> {
        let GetMetricsRequest { scaled_object_ref, metric_name } = request.into_inner();
        let slots = slots(&scaled_object_ref.unwrap_or_default())?;
        if metric_name != METRIC {
            let name = gonio_proto::convert::text(&metric_name);
            return Err(Status::not_found(format!("there is no metric {name:?}; ask for {METRIC}")));
        }
        let (metric_value_float, metric_value) = wanted(self.coordinator.broker.load(), slots);
        let value = MetricValue { metric_name, metric_value, metric_value_float };
        Ok(Response::new(GetMetricsResponse { metric_values: vec![value] }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queued_and_leased_tasks_are_shared_among_slots() {
        let load = |queued, leased| Load { queued, leased };
        assert_eq!(wanted(load(0, 0), 2), (0.0, 0));
        assert_eq!(wanted(load(4, 1), 2), (2.5, 3));
        assert_eq!(wanted(load(0, 1), 64), (1.0 / 64.0, 1));
    }

    #[test]
    fn a_trigger_without_sensible_slots_is_refused_with_the_mend() {
        let trigger = |slots: &[&str]| {
            let scaler_metadata = slots.iter().map(|slots| (SLOTS.to_owned(), (*slots).to_owned())).collect();
            ScaledObjectRef { name: "gonio-worker".to_owned(), namespace: String::new(), scaler_metadata }
        };
        assert_eq!(slots(&trigger(&["3"])).unwrap(), 3);
        for (given, expected) in [(&[][..], "has no slots"), (&["0"], "\"0\""), (&["many"], "from 1 on")] {
            let status = slots(&trigger(given)).unwrap_err();
            assert!(status.message().contains(expected) && status.message().contains("gonio-worker"), "{status}");
        }
    }
}
