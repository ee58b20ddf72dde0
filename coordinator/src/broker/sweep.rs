//! What only time tells: which workers are silent, and which tasks take too long at an evaluation's end.

use super::Broker;
use super::loss::Loss;
use super::pace::TARGET;
use super::state::State;
use gonio_proto::convert::request::Class;
use std::sync::Weak;
use std::time::Duration;
use tokio::time::{Instant, MissedTickBehavior};

/// How long a worker may be silent before its leases end, unless told otherwise. With the sweep's step it is noticed
/// within 5 s that a worker is lost.
pub const SILENCE: Duration = Duration::from_secs(4);

/// Sweeps without a beat after which a worker is silent. Sweeps are counted, not seconds: a coordinator that was paused
/// itself has heard nobody meanwhile, and must not take them all for lost.
pub const MOST_MISSED: u32 = 8;

/// Sweeps between two summaries in the log.
const SUMMARY: u32 = 120;

/// A task that was handed out so long ago, or whose rendering began so long ago, may be tried by another worker: a credit
/// buys a quarter of this, and two credits wait for each thread.
const STRAGGLING: Duration = Duration::from_millis(4 * TARGET.as_millis() as u64);

impl Broker {
    /// Ends the leases of workers that have fallen silent, and has stragglers tried twice.
    pub fn sweep(&self) {
        let mut state = self.state();
        let mut silent = Vec::new();
        for (id, worker) in &mut state.workers {
            worker.missed = worker.missed.saturating_add(1);
            if worker.missed == MOST_MISSED {
                silent.push((*id, worker.hello.name.clone()));
            }
        }
        for (worker, name) in silent {
            state.counters.silences += 1;
            state.settle(worker);
            let returned = state.end_leases(worker, Loss::Silent, &format!("worker {name} fell silent"));
            tracing::warn!(worker, name, returned, "worker silent");
        }
        state.dispatch();
        state.second_attempts(Instant::now());
    }

    /// Sweeps [`MOST_MISSED`] times in `silence`, for as long as the broker lives.
    pub async fn keep_sweeping(broker: Weak<Self>, silence: Duration) {
        let mut ticks = tokio::time::interval((silence / MOST_MISSED).max(Duration::from_millis(1)));
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let (mut sweeps, mut last) = (0_u32, None);
        loop {
            ticks.tick().await;
            let Some(broker) = broker.upgrade() else { return };
            broker.sweep();
            broker.pulse.beat();
            sweeps = sweeps.wrapping_add(1);
            let counters = broker.counters();
            if sweeps.is_multiple_of(SUMMARY) && last.replace(counters) != Some(counters) {
                tracing::info!(?counters, workers = broker.workers(), "so far");
            }
        }
    }
}

impl State {
    /// Lets workers with a free thread try what others have taken long for, where nothing else of an evaluation waits.
    fn second_attempts(&mut self, now: Instant) {
        let mut idle = self.hungry[Class::Interactive as usize].clone();
        idle.retain(|id| self.workers.get(id).is_some_and(|w| w.held < u64::from(w.hello.slots)));
        let Some(old) = now.checked_sub(STRAGGLING).filter(|_| !idle.is_empty()) else { return };
        let mut attempts = Vec::new();
        for (evaluation, entry) in self.evaluations.iter_mut().filter(|(_, entry)| entry.tasks.waiting() == 0) {
            let hungry = &self.hungry[entry.active.requester.class as usize];
            for (since, task, slow) in entry.tasks.stragglers(old) {
                let usual = entry.pace.expect(entry.samples(task)).unwrap_or_default();
                if now.duration_since(since) < 2 * usual {
                    continue;
                }
                let Some(worker) = idle.iter().find(|id| **id != slow && hungry.contains(id)).copied() else { break };
                let lease = super::tasks::Lease { worker, since: now, rendering: false, charged: 0 };
                let Some(attempt) = entry.tasks.second(task, lease) else { continue };
                idle.remove(&worker);
                attempts.push((worker, *evaluation, task, attempt));
            }
        }
        for (worker, evaluation, task, attempt) in attempts {
            tracing::debug!(evaluation, task, worker, "second attempt");
            self.send(worker, evaluation, &[(task, attempt)]);
            self.counters.second += 1;
        }
    }
}
