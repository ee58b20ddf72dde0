//! The broker: who works, what waits, who holds which lease.
//!
//! A worker's session, a client's stream and the sweep call in; every call takes the lock for microseconds. An attempt
//! ends in one of four ways: its worker commits it, gives it back, is gone, or lets its lease run out. After any but the
//! first the task is handed out again; after the first nothing adds to it any more.

pub mod active;
pub mod session;
mod state;
pub mod tasks;

pub use active::{Active, Failure, Outcome};
pub use state::{Counters, ToWorker};

use crate::split::Part;
use gonio_proto::convert::film::FilmShape;
use gonio_proto::convert::task::{AttemptId, Hello};
use gonio_proto::limits;
use gonio_proto::wire::{self, to_worker::Message};
use gonio_scene::Progress;
use state::{Entry, State, Worker};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;
use tasks::{Lease, Tasks};
use tokio::sync::mpsc;
use tokio::time::Instant;

/// How long a lease lasts unless told otherwise.
pub const LEASE: Duration = Duration::from_secs(30);

/// A task that was lost this often is given up, and its evaluation with it: it is more likely to be the cause than a victim.
pub const MOST_LOST_ATTEMPTS: u32 = 16;

/// Connects clients' evaluations with workers.
#[derive(Debug)]
pub struct Broker {
    epoch: u64,
    lease: Duration,
    /// Held for microseconds, by every call; never across an await.
    state: Mutex<State>,
}

impl Broker {
    /// A broker without work or workers. `epoch` must be larger after every restart.
    #[must_use]
    pub fn new(epoch: u64, lease: Duration) -> Arc<Self> {
        let state = State {
            epoch,
            lease,
            last_id: 0,
            workers: BTreeMap::new(),
            hungry: BTreeSet::new(),
            evaluations: BTreeMap::new(),
            last_served: (0, 0),
            counters: Counters::default(),
        };
        Arc::new(Self { epoch, lease, state: Mutex::new(state) })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // A panic under the lock would be a bug of ours; the others' work goes on.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What happened so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.state().counters
    }

    /// Adds a worker, and welcomes it; everything for it goes to `outbound`.
    pub fn join(&self, hello: Hello, outbound: mpsc::UnboundedSender<ToWorker>) -> u64 {
        let mut state = self.state();
        let id = state.new_id();
        tracing::info!(worker = id, name = hello.name, slots = hello.slots, "worker joined");
        let worker = Worker { hello, credits: 0, outbound, told: BTreeSet::new() };
        let lease_milliseconds = u32::try_from(self.lease.as_millis()).unwrap_or(u32::MAX);
        worker.send(Message::Welcome(wire::Welcome { worker: id, epoch: self.epoch, lease_milliseconds }));
        state.workers.insert(id, worker);
        id
    }

    /// Removes a worker and hands its tasks out again.
    pub fn leave(&self, worker: u64) {
        let mut state = self.state();
        state.hungry.remove(&worker);
        let Some(gone) = state.workers.remove(&worker) else { return };
        state.counters.workers_gone += 1;
        let returned =
            end_leases(&mut state, &format!("its worker {} is gone", gone.hello.name), |l| l.worker == worker);
        tracing::info!(worker, name = gone.hello.name, returned, "worker gone");
        state.dispatch();
    }

    /// Adds to a worker's credits.
    pub fn ask(&self, worker: u64, tasks: u32) {
        let mut state = self.state();
        let Some(asking) = state.workers.get_mut(&worker) else { return };
        asking.credits = asking.credits.saturating_add(tasks).min(limits::CREDITS);
        if asking.credits > 0 {
            state.hungry.insert(worker);
            state.dispatch();
        }
    }

    /// Extends the leases that `worker` holds among `attempts`.
    pub fn renew(&self, worker: u64, attempts: impl IntoIterator<Item = AttemptId>) {
        let expires = Instant::now() + self.lease;
        let mut state = self.state();
        for id in attempts {
            if let Some(entry) = state.entry(id) {
                entry.tasks.renew(id.task, id.attempt, Lease { worker, expires });
            }
        }
    }

    /// What the film of an attempt must look like, if `worker` holds its lease.
    #[must_use]
    pub fn expected_film(&self, worker: u64, id: AttemptId) -> Option<FilmShape> {
        let mut state = self.state();
        let entry = state.entry(id).filter(|entry| entry.tasks.is_held(id.task, id.attempt, worker))?;
        let part = entry.active.part(id.task)?;
        Some(entry.active.split.shape(part.tile))
    }

    /// Accepts an attempt's result, if `worker` holds its lease and the task is not committed: then the caller adds
    /// the film to the evaluation's reduction. Otherwise the result is late, and refused.
    #[must_use]
    pub fn commit(&self, worker: u64, id: AttemptId) -> Option<(Arc<Active>, Part)> {
        let mut state = self.state();
        let accepted = state.entry(id).and_then(|entry| {
            let part = entry.active.part(id.task)?;
            if !entry.tasks.commit(id.task, id.attempt, worker) {
                return None;
            }
            entry.camera_samples += entry.active.split.camera_samples(&part);
            Some((Arc::clone(&entry.active), part))
        });
        match accepted {
            Some(_) => state.counters.committed += 1,
            None => state.counters.refused += 1,
        }
        accepted
    }

    /// Counts a result that was refused before it came to a commit.
    pub fn refuse(&self, worker: u64, id: AttemptId, why: &str) {
        let mut state = self.state();
        state.counters.refused += 1;
        tracing::info!(worker, %id, why, refused = state.counters.refused, "result refused");
    }

    /// Ends an evaluation whose task no worker can render.
    pub fn fail(&self, worker: u64, id: AttemptId, text: &str) {
        let mut state = self.state();
        if let Some(entry) = state.entry(id).filter(|entry| entry.tasks.is_held(id.task, id.attempt, worker)) {
            entry.active.end(Err(Failure::of_request(gonio_proto::convert::text(text))));
        }
    }

    /// Takes a task back from a worker that will not render it.
    pub fn release(&self, worker: u64, id: AttemptId, text: &str) {
        let mut state = self.state();
        if state.entry(id).is_some() {
            give_back(&mut state, (id.evaluation, id.task, id.attempt, worker), text);
            state.dispatch();
        }
    }

    /// Takes back every task whose lease has run out.
    pub fn sweep(&self) {
        let now = Instant::now();
        let mut state = self.state();
        let expired = end_leases(&mut state, "its lease ran out", |lease| lease.expires <= now);
        if expired > 0 {
            state.counters.expired += expired;
            tracing::warn!(expired, "leases ran out");
            state.dispatch();
        }
    }

    /// Sweeps four times per lease, for as long as the broker lives.
    pub async fn keep_sweeping(broker: Weak<Self>, lease: Duration) {
        let mut ticks = tokio::time::interval((lease / 4).max(Duration::from_millis(1)));
        loop {
            ticks.tick().await;
            match broker.upgrade() {
                Some(broker) => broker.sweep(),
                None => return,
            }
        }
    }

    /// A number for a new evaluation.
    #[must_use]
    pub fn new_evaluation(&self) -> u64 {
        self.state().new_id()
    }

    /// Starts an evaluation; it runs until the registration is dropped.
    #[must_use]
    pub fn submit(self: &Arc<Self>, active: Arc<Active>) -> Registration {
        let evaluation = active.setup.evaluation;
        let tasks = Tasks::new(active.split.tasks());
        if active.split.tasks() == 0 {
            active.end(Ok(()));
        }
        let mut state = self.state();
        state.evaluations.insert(evaluation, Entry { active, tasks, camera_samples: 0 });
        state.dispatch();
        Registration { broker: Arc::clone(self), evaluation }
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
        state.evaluations.remove(&self.evaluation);
        for worker in state.workers.values_mut() {
            if worker.told.remove(&self.evaluation) {
                worker.send(Message::Cancel(wire::Cancel { evaluation: self.evaluation }));
            }
        }
    }
}

/// Ends the leases that `pick` picks and puts their tasks back; returns how many.
fn end_leases(state: &mut State, why: &str, pick: impl Fn(&Lease) -> bool + Copy) -> u64 {
    let mut ended = 0;
    let evaluations: Vec<u64> = state.evaluations.keys().copied().collect();
    for evaluation in evaluations {
        let leases = state.evaluations.get(&evaluation).map(|entry| entry.tasks.leased(pick)).unwrap_or_default();
        ended += leases.len() as u64;
        for (task, attempt, worker) in leases {
            give_back(state, (evaluation, task, attempt, worker), why);
        }
    }
    ended
}

fn give_back(state: &mut State, (evaluation, task, attempt, worker): (u64, u64, u32, u64), why: &str) {
    let Some(entry) = state.evaluations.get_mut(&evaluation) else { return };
    let Some(lost) = entry.tasks.give_back(task, attempt, worker) else { return };
    state.counters.returned += 1;
    tracing::debug!(evaluation, task, attempt, worker, why, "task returned");
    if lost >= MOST_LOST_ATTEMPTS {
        let text = format!("{} was lost {lost} times; the last time {why}", entry.active.describe(task));
        entry.active.end(Err(Failure::of_farm(text)));
    }
}
