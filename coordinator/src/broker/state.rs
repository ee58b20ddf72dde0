//! The broker's memory. One lock guards all of it; whoever holds it never waits, renders, decodes or reduces.

use super::active::Active;
use super::tasks::{Lease, Tasks};
use gonio_proto::convert::task::{AttemptId, Hello};
use gonio_proto::wire::{self, to_worker::Message};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Bound;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::time::Instant;

/// What happened since the start; every number only grows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Leases granted.
    pub granted: u64,
    /// Commits accepted.
    pub committed: u64,
    /// Commits refused because their lease had ended, or was never theirs.
    pub refused: u64,
    /// Leases that ran out.
    pub expired: u64,
    /// Tasks put back, for whatever reason.
    pub returned: u64,
    /// Workers whose stream ended.
    pub workers_gone: u64,
}

/// What a worker's stream carries towards it; an error ends it.
pub type ToWorker = Result<wire::ToWorker, tonic::Status>;

/// A connected worker.
#[derive(Debug)]
pub(super) struct Worker {
    /// Who it is.
    pub hello: Hello,
    /// Tasks that it may be handed: it adds by asking, every lease takes one.
    pub credits: u32,
    /// Towards the worker. Bounded by its credits and the evaluations it was told of, so the channel need not be.
    pub outbound: mpsc::UnboundedSender<ToWorker>,
    /// Evaluations whose setup it has.
    pub told: BTreeSet<u64>,
}

impl Worker {
    pub fn send(&self, message: Message) {
        // A session that has ended is about to report its worker gone.
        let _ = self.outbound.send(Ok(wire::ToWorker { message: Some(message) }));
    }
}

/// An evaluation and the state of its tasks.
#[derive(Debug)]
pub(super) struct Entry {
    pub active: Arc<Active>,
    pub tasks: Tasks,
    /// Camera samples of committed tasks.
    pub camera_samples: u64,
}

/// Everything that the broker knows.
#[derive(Debug)]
pub(super) struct State {
    pub epoch: u64,
    pub lease: Duration,
    /// The last number given to a worker or an evaluation.
    pub last_id: u64,
    /// By number. Added when a worker says hello, removed when its stream ends.
    pub workers: BTreeMap<u64, Worker>,
    /// Workers with credits left.
    pub hungry: BTreeSet<u64>,
    /// By number. Added when a client's request is split, removed when its stream ends.
    pub evaluations: BTreeMap<u64, Entry>,
    /// The worker and the evaluation of the last lease: the next ones have their turn.
    pub last_served: (u64, u64),
    pub counters: Counters,
}

impl State {
    pub fn new_id(&mut self) -> u64 {
        self.last_id += 1;
        self.last_id
    }

    /// Hands out tasks while somebody wants one and there is one, workers and evaluations in turn.
    pub fn dispatch(&mut self) {
        loop {
            let (last_worker, last_evaluation) = self.last_served;
            let after = (Bound::Excluded(last_evaluation), Bound::Unbounded);
            let mut turns = self.evaluations.range(after).chain(self.evaluations.range(..=last_evaluation));
            let Some(evaluation) = turns.find(|(_, e)| e.tasks.is_ready()).map(|(id, _)| *id) else { return };
            let after = (Bound::Excluded(last_worker), Bound::Unbounded);
            let mut turns = self.hungry.range(after).chain(self.hungry.range(..=last_worker));
            let Some(worker) = turns.next().copied() else { return };
            self.grant(worker, evaluation);
            self.last_served = (worker, evaluation);
        }
    }

    /// Leases the next task of an evaluation to a worker with credits.
    fn grant(&mut self, worker_id: u64, evaluation: u64) {
        let (Some(worker), Some(entry)) = (self.workers.get_mut(&worker_id), self.evaluations.get_mut(&evaluation))
        else {
            self.hungry.remove(&worker_id);
            return;
        };
        worker.credits = worker.credits.saturating_sub(1);
        if worker.credits == 0 {
            self.hungry.remove(&worker_id);
        }
        let Some((task, attempt)) = entry.tasks.take(Lease { worker: worker_id, expires: Instant::now() + self.lease })
        else {
            return;
        };
        let id = AttemptId { epoch: self.epoch, evaluation, task, attempt };
        if worker.told.insert(evaluation) {
            worker.send(Message::Setup((&entry.active.setup).into()));
        }
        if let Some(task) = entry.active.task(id) {
            worker.send(Message::Task((&task).into()));
        }
        self.counters.granted += 1;
    }

    /// The evaluation of an attempt of this epoch.
    pub fn entry(&mut self, id: AttemptId) -> Option<&mut Entry> {
        (id.epoch == self.epoch).then(|| self.evaluations.get_mut(&id.evaluation)).flatten()
    }
}
