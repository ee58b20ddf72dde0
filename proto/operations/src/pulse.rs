//! Whether something that should come round does.

use crate::Verdict;
use std::future::Future;
use std::pin::pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tokio::time::MissedTickBehavior;

/// How often [`Pulse::beside`] beats.
const BEAT: Duration = Duration::from_secs(1);

/// When something last came round. It never waits and takes no lock.
#[derive(Debug)]
pub struct Pulse {
    origin: Instant,
    /// Milliseconds since `origin`.
    last: AtomicU64,
}

impl Default for Pulse {
    /// Has come round now.
    fn default() -> Self {
        Self { origin: Instant::now(), last: AtomicU64::new(0) }
    }
}

impl Pulse {
    /// Notes that it comes round.
    pub fn beat(&self) {
        let now = u64::try_from(self.origin.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.last.store(now, Ordering::Relaxed);
    }

    /// How long ago it came round.
    #[must_use]
    pub fn age(&self) -> Duration {
        self.origin.elapsed().saturating_sub(Duration::from_millis(self.last.load(Ordering::Relaxed)))
    }

    /// Well if it came round within `bound`; `what` names it.
    ///
    /// # Errors
    /// It did not.
    pub fn within(&self, bound: Duration, what: &str) -> Verdict {
        let age = self.age();
        if age <= bound { Ok(()) } else { Err(format!("{what} has not come round for {} s", age.as_secs())) }
    }

    /// Runs a future, and beats once a second in the same task: the pulse stops if the future holds the task up, not while
    /// it waits.
    pub async fn beside<F: Future>(&self, future: F) -> F::Output {
        let mut future = pin!(future);
        let mut ticks = tokio::time::interval(BEAT);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                output = &mut future => return output,
                _ = ticks.tick() => self.beat(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn what_waits_beats_and_what_blocks_does_not() {
        let pulse = Pulse::default();
        pulse.beside(tokio::time::sleep(Duration::from_millis(2200))).await;
        assert!(pulse.age() < Duration::from_millis(500), "{:?}", pulse.age());
        let blocked = async {
            tokio::task::yield_now().await;
            std::thread::sleep(Duration::from_millis(1200));
            pulse.age()
        };
        let age = pulse.beside(blocked).await;
        assert!(age >= Duration::from_millis(1100), "{age:?}");
        assert!(pulse.within(Duration::from_secs(60), "it").is_ok());
        assert!(pulse.within(Duration::from_millis(1), "the loop").unwrap_err().contains("the loop has not"));
    }
}
