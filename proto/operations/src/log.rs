//! How a program's log is written, and where its spans go.

use clap::ValueEnum;
use tracing_subscriber::EnvFilter;

/// Names the collector of spans; OpenTelemetry's own variable.
const COLLECTOR: &str = "OTEL_EXPORTER_OTLP_ENDPOINT";

/// The form of a log's lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Log {
    /// For people.
    #[default]
    Text,
    /// One JSON object per line: `timestamp`, `level`, `target`, `message`, and the event's fields beside them.
    Json,
}

/// A log that has begun; dropped, it sends the spans that wait.
#[derive(Debug)]
#[must_use = "spans are sent while it lives"]
pub struct Logging {
    #[cfg(feature = "otel")]
    _spans: Option<crate::otel::Spans>,
}

impl Log {
    /// Starts the log of `program` on stderr: what `RUST_LOG` asks for, else from `level` on. With the feature `otel`, spans
    /// go to the collector that `OTEL_EXPORTER_OTLP_ENDPOINT` names, if it is set.
    ///
    /// # Errors
    /// The collector's address is none.
    pub fn start(self, program: &'static str, level: &str) -> std::io::Result<Logging> {
        let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(level));
        let collector = std::env::var_os(COLLECTOR).is_some_and(|value| !value.is_empty());
        self.with(program, filter, collector)
    }

    #[cfg(not(feature = "otel"))]
    #[allow(clippy::unnecessary_wraps)] // With the feature, it can fail.
    fn with(self, program: &'static str, filter: EnvFilter, collector: bool) -> std::io::Result<Logging> {
        let lines = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr);
        match self {
            Self::Text => lines.init(),
            Self::Json => lines.json().flatten_event(true).with_current_span(false).with_span_list(false).init(),
        }
        if collector {
            tracing::warn!("{COLLECTOR} is set, but {program} was built without the feature otel: no span is sent");
        }
        Ok(Logging {})
    }

    #[cfg(feature = "otel")]
    fn with(self, program: &'static str, filter: EnvFilter, collector: bool) -> std::io::Result<Logging> {
        use tracing_subscriber::filter::Targets;
        use tracing_subscriber::prelude::*;
        let lines = tracing_subscriber::fmt::layer().with_writer(std::io::stderr);
        let lines = match self {
            Self::Text => lines.boxed(),
            Self::Json => lines.json().flatten_event(true).with_current_span(false).with_span_list(false).boxed(),
        };
        let named = |error: std::io::Error| std::io::Error::other(format!("{COLLECTOR}: {error}"));
        let spans = collector.then(|| crate::otel::Spans::start(program)).transpose().map_err(named)?;
        // Ours alone: the transport that carries spans has spans of its own.
        let ours = Targets::new().with_target("gonio", tracing::Level::INFO);
        let traces =
            spans.as_ref().map(|spans| tracing_opentelemetry::layer().with_tracer(spans.tracer()).with_filter(ours));
        tracing_subscriber::registry().with(lines.with_filter(filter)).with(traces).init();
        Ok(Logging { _spans: spans })
    }
}
