//! Sends spans to an OpenTelemetry collector, by OTLP over gRPC.

use opentelemetry::propagation::TextMapPropagator;
use opentelemetry::trace::TracerProvider;
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::propagation::TraceContextPropagator;
use opentelemetry_sdk::trace::{SdkTracerProvider, Tracer};
use std::collections::HashMap;
use std::io;
use tokio::runtime::Runtime;
use tracing::Span;
use tracing_opentelemetry::OpenTelemetrySpanExt;

/// The header that names a span.
const TRACE_PARENT: &str = "traceparent";

/// Where spans go; dropped, it sends those that wait.
#[derive(Debug)]
pub(crate) struct Spans {
    provider: SdkTracerProvider,
    /// Carries them: a program's own may have ended by then. `None` once it is dropped.
    runtime: Option<Runtime>,
}

impl Spans {
    /// The collector that `OTEL_EXPORTER_OTLP_ENDPOINT` names, to which the spans of `program` go.
    ///
    /// # Errors
    /// The address is none, or there are no threads to be had.
    pub fn start(program: &'static str) -> io::Result<Self> {
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build()?;
        let entered = runtime.enter();
        let exporter = opentelemetry_otlp::SpanExporter::builder().with_tonic().build().map_err(io::Error::other)?;
        drop(entered);
        let resource = Resource::builder().with_service_name(program).build();
        let provider = SdkTracerProvider::builder().with_batch_exporter(exporter).with_resource(resource).build();
        Ok(Self { provider, runtime: Some(runtime) })
    }

    pub fn tracer(&self) -> Tracer {
        self.provider.tracer("gonio")
    }
}

impl Drop for Spans {
    fn drop(&mut self) {
        if let Err(error) = self.provider.shutdown() {
            tracing::warn!(%error, "the last spans were not sent");
        }
        // It may be dropped where waiting for its threads is not allowed.
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

pub(crate) fn trace_parent() -> String {
    let mut carrier = HashMap::new();
    TraceContextPropagator::new().inject_context(&Span::current().context(), &mut carrier);
    carrier.remove(TRACE_PARENT).unwrap_or_default()
}

pub(crate) fn follow(span: &Span, trace_parent: &str) {
    let carrier = HashMap::from([(TRACE_PARENT.to_owned(), trace_parent.to_owned())]);
    // One that nobody records has no parent either.
    let _ = span.set_parent(TraceContextPropagator::new().extract(&carrier));
}
