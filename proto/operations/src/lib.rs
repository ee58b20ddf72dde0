//! What a program of the farm shows to those who run it: whether it is well, what it has done, which build it is.
//!
//! [`serve`] answers on a port of its own, over plain HTTP and on a thread of its own, so that it still answers when the rest
//! of the program hangs:
//!
//! | path | 200 when |
//! | --- | --- |
//! | `/healthz/startup` | the program has come up |
//! | `/healthz/ready` | it takes work |
//! | `/healthz/live` | it has not hung: a restart would not help |
//! | `/metrics` | always, in Prometheus' text format 0.0.4 |
//!
//! Probes that fail are answered by 503 and the reason. Nothing here asks who calls: what is told is names and numbers.

mod arguments;
mod distribution;
mod families;
mod log;
#[cfg(feature = "otel")]
mod otel;
mod probe;
mod pulse;
mod server;
mod trace;

pub use arguments::OperationsArguments;
pub use distribution::Distribution;
pub use families::Families;
pub use log::{Log, Logging};
pub use probe::{Probe, Verdict};
pub use pulse::Pulse;
pub use server::serve;
pub use trace::{follow, trace_parent};

/// The commit that was built, or "unknown" where neither its clone nor `GONIO_COMMIT` told.
pub const COMMIT: &str = env!("GONIO_COMMIT");

/// Version and commit, as `--version` shows them.
pub const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("GONIO_COMMIT"), ")");
