//! Evaluations beyond their clients' streams: who asks again with the same key hears the rest.

mod job;
mod registry;

pub use job::{Answer, End, Job, Listener};
pub use registry::{Jobs, MOST};

use std::time::Duration;

/// How long an evaluation with a key goes on when nobody listens to it.
pub const LINGER: Duration = Duration::from_secs(30);
