//! The broker: who works, what waits, who holds which lease.
//!
//! A worker's session, a client's stream and the sweep call in; every call takes the lock for microseconds. A lease ends in
//! one of five ways: its worker commits the task, gives it back, is gone, or falls silent, or another attempt has committed
//! it. Where no attempt is left the task is handed out again; after a commit nothing adds to it any more.

pub mod active;
mod counters;
mod look;
pub mod loss;
mod pace;
mod reissue;
pub mod session;
mod shares;
mod speed;
mod state;
mod survey;
mod sweep;
pub mod tasks;
mod traffic;
mod workers;

pub use active::{Active, Failure, Outcome};
pub use counters::Counters;
pub use look::{Activity, Strength, WorkerLook};
pub use loss::Loss;
pub use shares::INTERACTIVE_WEIGHT;
pub use state::ToWorker;
pub use survey::{Load, Survey, WorkerSurvey};
pub use sweep::SILENCE;
pub use traffic::Traffic;

use gonio_operations::{Distribution, Pulse};
use gonio_proto::wire::{self, to_worker::Message};
use gonio_scene::Progress;
use state::{Entry, State};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tasks::Tasks;
use tokio::sync::watch;

/// Connects clients' evaluations with workers.
#[derive(Debug)]
pub struct Broker {
    epoch: u64,
    silence: Duration,
    /// Held for microseconds, by every call; never across an await.
    state: Mutex<State>,
    /// Set once, by [`Broker::close`]; every worker's session waits for it.
    closed: watch::Sender<bool>,
    /// Beats after every sweep, which takes the lock: it stops where that never comes free.
    pub pulse: Pulse,
    /// Render time of every task committed.
    pub render_times: Distribution,
    /// Bytes that came and went.
    pub traffic: Traffic,
}

impl Broker {
    /// A broker without work or workers. `epoch` must be larger after every restart; workers that do not beat for `silence`
    /// lose their leases.
    #[must_use]
    pub fn new(epoch: u64, silence: Duration) -> Arc<Self> {
        let state = Mutex::new(State::new(epoch));
        let (pulse, render_times, traffic) = (Pulse::default(), Distribution::default(), Traffic::default());
        Arc::new(Self { epoch, silence, state, closed: watch::Sender::new(false), pulse, render_times, traffic })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // A panic under the lock would be a bug of ours; the others' work goes on.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Larger than that of every coordinator of this farm before.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// What happened so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.state().counters
    }

    /// Workers connected.
    #[must_use]
    pub fn workers(&self) -> usize {
        self.state().workers.len()
    }

    /// Workers connected, and the tasks that they render at the same time.
    #[must_use]
    pub fn strength(&self) -> (u32, u64) {
        let state = self.state();
        (u32::try_from(state.workers.len()).unwrap_or(u32::MAX), state.slots)
    }

    /// Ends every worker's stream, those of workers yet to come too.
    pub fn close(&self) {
        self.closed.send_replace(true);
    }

    /// Completes when the broker is closed.
    pub async fn closed(&self) {
        // The sender lives as long as `self`.
        let _ = self.closed.subscribe().wait_for(|closed| *closed).await;
    }

    /// A number for a new evaluation.
    #[must_use]
    pub fn new_evaluation(&self) -> u64 {
        self.state().new_id()
    }

    /// Starts an evaluation; it runs until the registration is dropped.
    #[must_use]
    pub fn submit(self: &Arc<Self>, active: Arc<Active>) -> Registration {
        self.resume(active, &[])
    }

    /// Starts an evaluation of which its reduction has these tiles already.
    #[must_use]
    pub fn resume(self: &Arc<Self>, active: Arc<Active>, restored: &[usize]) -> Registration {
        let evaluation = active.setup.evaluation;
        let mut tasks = Tasks::new(active.split.tasks());
        let mut camera_samples = 0;
        for part in restored.iter().flat_map(|tile| active.split.tasks_of(*tile)) {
            tasks.restore(part.0);
            camera_samples += active.split.camera_samples(&part.1);
        }
        if active.reduction.collecting() == 0 {
            active.end(Ok(()));
        }
        let mut state = self.state();
        state.shares.enter(evaluation, &active.requester);
        state.shares.set_waiting(evaluation, tasks.waiting() > 0);
        state.evaluations.insert(evaluation, Entry { active, tasks, camera_samples, pace: pace::Pace::default() });
        state.dispatch();
        Registration { broker: Arc::clone(self), evaluation }
    }

    /// Ends all evaluations that run.
    pub fn fail_all(&self, failure: &Failure) {
        for entry in self.state().evaluations.values() {
            entry.active.end(Err(failure.clone()));
        }
    }

    /// How far an evaluation is; the loss is left out.
    #[must_use]
    pub fn progress(&self, evaluation: u64) -> Progress {
        let state = self.state();
        let mut progress =
            Progress { workers: u32::try_from(state.workers.len()).unwrap_or(u32::MAX), ..Progress::default() };
        if let Some(entry) = state.evaluations.get(&evaluation) {
            (progress.tasks_done, progress.tasks) = entry.tasks.done();
            progress.primary_samples = entry.camera_samples;
        }
        progress
    }
}

/// Keeps an evaluation running; dropped, it is over: its workers are told, its tasks forgotten.
#[derive(Debug)]
pub struct Registration {
    broker: Arc<Broker>,
    evaluation: u64,
}

impl Drop for Registration {
    fn drop(&mut self) {
        let mut state = self.broker.state();
        state.shares.leave(self.evaluation);
        state.speeds.end(self.evaluation);
        let leases = state.evaluations.remove(&self.evaluation).map(|entry| entry.tasks.leased(|_| true));
        for (_, _, worker) in leases.unwrap_or_default() {
            state.let_go(worker, 1);
        }
        for worker in state.workers.values_mut() {
            if worker.told.remove(&self.evaluation).is_some() {
                worker.send(Message::Cancel(wire::Cancel { evaluation: self.evaluation }));
            }
        }
    }
}
