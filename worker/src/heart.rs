//! The beat that tells a coordinator that this worker lives: by a task and, where there is a network, a connection of its
//! own, so that neither a film on its way nor a full channel delays it.

use futures::future::BoxFuture;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, timeout};
use tonic::{Code, Status};

/// Beats in the time after which a silent worker is taken for lost.
const BEATS: u32 = 4;

/// Carries beats to a coordinator.
pub trait Heart: Send + Sync {
    /// Says that a worker lives. [`Code::NotFound`]: the coordinator knows no such worker.
    fn beat(&self, worker: u64, epoch: u64) -> BoxFuture<'_, Result<(), Status>>;
}

/// Beats until the coordinator knows the worker no more; returns what it said.
pub(crate) async fn keep_beating(heart: Arc<dyn Heart>, worker: u64, epoch: u64, silence: Duration) -> Status {
    let pause = (silence / BEATS).max(Duration::from_millis(1));
    let mut ticks = tokio::time::interval(pause);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        ticks.tick().await;
        // One that hangs must not keep the next from trying.
        match timeout(pause, heart.beat(worker, epoch)).await {
            Ok(Err(status)) if status.code() == Code::NotFound => return status,
            Ok(Err(status)) => tracing::debug!(reason = status.message(), "a beat failed"),
            Ok(Ok(())) => {}
            Err(_) => tracing::debug!("a beat was not answered in time"),
        }
    }
}
