//! The broker's memory. One lock guards all of it; whoever holds it never waits, renders, decodes or reduces.

use super::active::{Active, Failure};
use super::counters::Counters;
use super::loss::Loss;
use super::pace::{Pace, TARGET};
use super::shares::Shares;
use super::speed::Speeds;
use super::sweep::MOST_MISSED;
use super::tasks::{Lease, Tasks};
use gonio_proto::convert::request::Class;
use gonio_proto::convert::task::{AttemptId, Hello};
use gonio_proto::limits;
use gonio_proto::wire::{self, to_worker::Message};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Bound;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::time::Instant;

/// What a task is charged before anything of its evaluation was measured, microseconds per camera sample. It is corrected
/// when the task is committed; until then only its order of magnitude matters.
const GUESSED_MICROS_PER_SAMPLE: u64 = 1;

/// Most bytes of films that one credit asks a worker for, unless a single task has more: they wait for its network in memory.
const MOST_FILM_BYTES: usize = 16 << 20;

/// What a worker's stream carries towards it; an error ends it.
pub type ToWorker = Result<wire::ToWorker, tonic::Status>;

/// A connected worker.
#[derive(Debug)]
pub(super) struct Worker {
    /// Who it is.
    pub hello: Hello,
    /// Tasks messages that it may be sent: it adds by asking, every message takes one.
    pub credits: u32,
    /// Whether it stops: then it gets nothing any more.
    pub leaving: bool,
    /// Leases that it holds.
    pub held: u64,
    /// Sweeps since its last beat.
    pub missed: u32,
    /// Towards the worker. Bounded by its credits and the evaluations it was told of, so the channel need not be.
    pub outbound: mpsc::UnboundedSender<ToWorker>,
    /// Evaluations whose setup it has, and how fast it renders them.
    pub told: BTreeMap<u64, Pace>,
    /// Camera samples of the tasks that it committed.
    pub camera_samples: u64,
    /// What these took, of one render thread.
    pub render_time: Duration,
}

impl Worker {
    pub fn send(&self, message: Message) {
        // A session that has ended is about to report its worker gone.
        let _ = self.outbound.send(Ok(wire::ToWorker { message: Some(message) }));
    }

    /// Whether it has not beaten for so long that its leases have ended.
    pub fn is_silent(&self) -> bool {
        self.missed >= MOST_MISSED
    }

    /// Whether it may be sent tasks of a class, credits alone considered.
    pub fn takes(&self, class: Class) -> bool {
        match class {
            Class::Interactive => self.credits > 0,
            Class::Batch => self.credits > self.hello.reserved_credits,
        }
    }
}

/// An evaluation and the state of its tasks.
#[derive(Debug)]
pub(super) struct Entry {
    pub active: Arc<Active>,
    pub tasks: Tasks,
    /// Camera samples of committed tasks.
    pub camera_samples: u64,
    /// How fast the farm renders it.
    pub pace: Pace,
}

impl Entry {
    /// Camera samples of a task.
    pub fn samples(&self, task: u64) -> u64 {
        self.active.part(task).map_or(0, |part| self.active.split.camera_samples(&part))
    }
}

/// Everything that the broker knows.
#[derive(Debug)]
pub(super) struct State {
    pub epoch: u64,
    /// The last number given to a worker or an evaluation.
    pub last_id: u64,
    /// By number. Added when a worker says hello, removed when its stream ends.
    pub workers: BTreeMap<u64, Worker>,
    /// Render threads of all workers.
    pub slots: u64,
    /// Workers that beat and whose credits a class may use: interactive, then batch. Kept by [`State::settle`].
    pub hungry: [BTreeSet<u64>; 2],
    /// By number. Added when a client's request is split, removed when its stream ends.
    pub evaluations: BTreeMap<u64, Entry>,
    /// Whose evaluation is next.
    pub shares: Shares,
    /// The worker of the last lease: the next ones have their turn.
    pub last_served: u64,
    pub counters: Counters,
    /// Of the workers above, from hello to the stream's end, and of evaluations from their first commit.
    pub speeds: Speeds,
}

impl State {
    pub fn new(epoch: u64) -> Self {
        Self {
            epoch,
            last_id: 0,
            workers: BTreeMap::new(),
            slots: 0,
            hungry: Default::default(),
            evaluations: BTreeMap::new(),
            shares: Shares::default(),
            last_served: 0,
            counters: Counters::default(),
            speeds: Speeds::default(),
        }
    }

    pub fn new_id(&mut self) -> u64 {
        self.last_id += 1;
        self.last_id
    }

    /// Notes whether a worker may be handed tasks, after anything that bears on it has changed.
    pub fn settle(&mut self, worker: u64) {
        for class in [Class::Interactive, Class::Batch] {
            let hungry = self.workers.get(&worker).is_some_and(|w| !w.leaving && !w.is_silent() && w.takes(class));
            let set = &mut self.hungry[class as usize];
            if hungry {
                set.insert(worker)
            } else {
                set.remove(&worker)
            };
        }
    }

    /// Hands out tasks while somebody wants one and there is one: clients by their shares, workers in turn.
    pub fn dispatch(&mut self) {
        while !self.hungry[Class::Interactive as usize].is_empty() {
            let Some((evaluation, class)) = self.shares.next(|class| !self.hungry[class as usize].is_empty()) else {
                return;
            };
            let hungry = &self.hungry[class as usize];
            let after = (Bound::Excluded(self.last_served), Bound::Unbounded);
            let Some(worker) = hungry.range(after).next().or_else(|| hungry.first()).copied() else { return };
            self.grant(worker, evaluation);
            self.last_served = worker;
        }
    }

    /// Sends a worker what one of its credits buys of an evaluation.
    fn grant(&mut self, worker: u64, evaluation: u64) {
        let tasks = self.take(worker, evaluation).unwrap_or_default();
        let waits = self.evaluations.get(&evaluation).is_some_and(|entry| entry.tasks.waiting() > 0);
        self.shares.set_waiting(evaluation, waits);
        self.send(worker, evaluation, &tasks);
    }

    /// Leases about [`TARGET`] of an evaluation's work to a worker, but of what waits no more than leaves several times as
    /// much for every other thread: so the last batches are small, and all threads end together.
    fn take(&mut self, worker_id: u64, evaluation: u64) -> Option<Vec<(u64, u32)>> {
        let (worker, entry) = (self.workers.get_mut(&worker_id)?, self.evaluations.get_mut(&evaluation)?);
        let pace = worker.told.get(&evaluation).copied().unwrap_or_default();
        let fair = (entry.tasks.waiting() / (4 * self.slots).max(1)).clamp(1, limits::TASKS_AT_ONCE as u64);
        let (mut taken, mut time, mut bytes) = (Vec::new(), Duration::ZERO, 0);
        while let Some(next) = entry.tasks.next() {
            let samples = entry.samples(next);
            let expected = pace.expect(samples).or_else(|| entry.pace.expect(samples));
            // Nothing is known: one task will tell.
            time += expected.unwrap_or(TARGET);
            bytes += entry.active.part(next).map_or(0, |part| entry.active.split.shape(part.tile).bytes());
            let enough = taken.len() as u64 >= fair || time > TARGET || bytes > MOST_FILM_BYTES;
            if enough && !taken.is_empty() {
                break;
            }
            let charged = expected.map_or(GUESSED_MICROS_PER_SAMPLE * samples, |time| time.as_micros() as u64);
            let charged = u32::try_from(charged).unwrap_or(u32::MAX);
            let lease = Lease { worker: worker_id, since: Instant::now(), rendering: false, charged };
            taken.extend(entry.tasks.take(lease));
            self.shares.charge(evaluation, charged.into());
        }
        Some(taken)
    }

    /// Sends a worker leases that it was granted, with the setup if it is the first of its evaluation.
    pub fn send(&mut self, worker_id: u64, evaluation: u64, leases: &[(u64, u32)]) {
        let (Some(worker), Some(entry)) = (self.workers.get_mut(&worker_id), self.evaluations.get(&evaluation)) else {
            return;
        };
        if leases.is_empty() {
            return;
        }
        let id =
            |(task, attempt): &(u64, u32)| AttemptId { epoch: self.epoch, evaluation, task: *task, attempt: *attempt };
        let tasks = leases.iter().filter_map(|lease| entry.active.task(id(lease)));
        let tasks = wire::Tasks { tasks: tasks.map(|task| (&task).into()).collect() };
        worker.told.entry(evaluation).or_insert_with(|| {
            let _ = worker
                .outbound
                .send(Ok(wire::ToWorker { message: Some(Message::Setup((&entry.active.setup).into())) }));
            Pace::default()
        });
        worker.send(Message::Tasks(tasks));
        worker.credits = worker.credits.saturating_sub(1);
        worker.held += leases.len() as u64;
        self.counters.granted += leases.len() as u64;
        self.settle(worker_id);
    }

    /// The evaluation of an attempt of this epoch.
    pub fn entry(&mut self, id: AttemptId) -> Option<&mut Entry> {
        (id.epoch == self.epoch).then(|| self.evaluations.get_mut(&id.evaluation)).flatten()
    }

    /// Notes that a worker holds `leases` fewer.
    pub fn let_go(&mut self, worker: u64, leases: u64) {
        if let Some(worker) = self.workers.get_mut(&worker) {
            worker.held = worker.held.saturating_sub(leases);
        }
    }

    /// Ends all leases of a worker and puts their tasks back; returns how many.
    pub fn end_leases(&mut self, worker: u64, loss: Loss, why: &str) -> u64 {
        let mut ended = 0;
        let evaluations: Vec<u64> = self.evaluations.keys().copied().collect();
        for evaluation in evaluations {
            let leases = self.evaluations.get(&evaluation).map(|entry| entry.tasks.leased(|l| l.worker == worker));
            for (task, attempt, _) in leases.unwrap_or_default() {
                ended += 1;
                self.give_back((evaluation, task, attempt, worker), loss, why);
            }
        }
        ended
    }

    /// Ends an attempt without a result. A task that was lost too often is set aside, and its evaluation ends.
    pub fn give_back(&mut self, attempt: (u64, u64, u32, u64), loss: Loss, why: &str) {
        let (evaluation, task, attempt, worker) = attempt;
        let Some(entry) = self.evaluations.get_mut(&evaluation) else { return };
        let Some(history) = entry.tasks.give_back(task, attempt, worker, loss) else { return };
        tracing::debug!(evaluation, task, attempt, worker, why, "task returned");
        self.counters.returned += 1;
        if !history.is_bearable() {
            let text = history.verdict(&entry.active.describe(task), why);
            tracing::warn!(evaluation, text, "task set aside");
            entry.tasks.stop();
            entry.active.end(Err(Failure::of_farm(text)));
            self.counters.set_aside += 1;
        }
        let waits = entry.tasks.waiting() > 0;
        self.shares.set_waiting(evaluation, waits);
        self.let_go(worker, 1);
    }
}
