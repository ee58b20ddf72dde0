//! How a program's log is written.

use clap::ValueEnum;
use tracing_subscriber::EnvFilter;

/// The form of a log's lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Log {
    /// For people.
    #[default]
    Text,
    /// One JSON object per line: `timestamp`, `level`, `target`, `message`, and the event's fields beside them.
    Json,
}

/// Starts the log, on stderr: what `RUST_LOG` asks for, else from level info on.
pub fn start_log(log: Log) {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("info"));
    let lines = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr);
    match log {
        Log::Text => lines.init(),
        Log::Json => lines.json().flatten_event(true).with_current_span(false).with_span_list(false).init(),
    }
}
