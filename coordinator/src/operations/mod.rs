//! A coordinator as those who run it see it: starting, standing by, serving or draining; alive or hung; and in numbers.

mod metrics;

use crate::Coordinator;
use gonio_operations::{Families, Probe, Verdict};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::Duration;

/// A broker that has not swept for so long hangs: it does so twice a second.
const HUNG: Duration = Duration::from_secs(30);

/// Where a coordinator is in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// It opens its store, or reads the journal.
    Starting,
    /// Another owns the farm, and it waits to take over.
    Standby,
    /// It owns the farm, and takes workers and evaluations.
    Serving,
    /// It takes no evaluation any more, and ends.
    Draining,
}

impl Phase {
    /// In the order of life.
    const ALL: [Self; 4] = [Self::Starting, Self::Standby, Self::Serving, Self::Draining];

    fn name(self) -> &'static str {
        match self {
            Self::Starting => "starting",
            Self::Standby => "standby",
            Self::Serving => "serving",
            Self::Draining => "draining",
        }
    }
}

/// What the operations port asks.
#[derive(Debug, Default)]
pub struct Operations {
    /// A [`Phase`]; [`Phase::Starting`] by default.
    phase: AtomicU8,
    /// Whether it has been in any other phase than the first.
    coordinator: OnceLock<Coordinator>,
}

impl Operations {
    /// Notes where it is now.
    pub fn enter(&self, phase: Phase) {
        self.phase.store(phase as u8, Ordering::Release);
    }

    /// Notes that `coordinator` owns the farm and is about to listen.
    pub fn serve(&self, coordinator: &Coordinator) {
        // It is set once: a process owns its farm once.
        let _ = self.coordinator.set(coordinator.clone());
        self.enter(Phase::Serving);
    }

    fn phase(&self) -> Phase {
        let phase = self.phase.load(Ordering::Acquire);
        Phase::ALL.into_iter().find(|known| *known as u8 == phase).unwrap_or(Phase::Starting)
    }
}

impl Probe for Operations {
    fn startup(&self) -> Verdict {
        match self.phase() {
            Phase::Starting => Err("it starts: the store is opened, its journal read".to_owned()),
            _ => Ok(()),
        }
    }

    fn ready(&self) -> Verdict {
        match self.phase() {
            Phase::Starting => Err("it starts: the store is opened, its journal read".to_owned()),
            Phase::Standby => Err("it stands by: another coordinator owns the farm".to_owned()),
            Phase::Draining => Err("it drains: no evaluation is taken any more".to_owned()),
            Phase::Serving if self.coordinator.get().is_some_and(Coordinator::is_lost) => {
                Err("another coordinator has taken the farm over".to_owned())
            }
            Phase::Serving => self.live(),
        }
    }

    fn live(&self) -> Verdict {
        match self.coordinator.get() {
            Some(coordinator) => coordinator.broker.pulse.within(HUNG, "the broker's sweep"),
            // Until it owns the farm, to answer is all that it can do.
            None => Ok(()),
        }
    }

    fn metrics(&self) -> Families {
        metrics::families(self.phase(), self.coordinator.get())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Blobs;

    fn coordinator(silence: Duration) -> Coordinator {
        Coordinator::new(Blobs::open("memory://").unwrap(), silence)
    }

    #[tokio::test]
    async fn probes_follow_the_phase() {
        let operations = Operations::default();
        let told = |o: &Operations| (o.startup().is_ok(), o.ready().is_ok(), o.live().is_ok());
        assert_eq!(told(&operations), (false, false, true));
        operations.enter(Phase::Standby);
        assert_eq!(told(&operations), (true, false, true));
        operations.serve(&coordinator(Duration::from_secs(4)));
        assert_eq!(told(&operations), (true, true, true));
        operations.enter(Phase::Draining);
        assert_eq!(told(&operations), (true, false, true));
    }

    /// A call that never lets go of the broker's lock is noticed, by a probe that does not wait for it.
    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_broker_whose_lock_never_comes_free_is_not_alive() {
        let coordinator = coordinator(Duration::from_millis(80));
        let bound = Duration::from_millis(300);
        let live = || coordinator.broker.pulse.within(bound, "the broker's sweep");
        tokio::time::sleep(Duration::from_millis(600)).await;
        assert!(live().is_ok(), "it sweeps every 10 ms");
        let hung = tokio::task::block_in_place(|| {
            let _held = coordinator.broker.hang();
            std::thread::sleep(Duration::from_millis(600));
            live()
        });
        assert!(hung.unwrap_err().contains("the broker's sweep has not come round"));
        tokio::time::sleep(Duration::from_millis(200)).await;
        assert!(live().is_ok(), "and it goes on");
    }
}
