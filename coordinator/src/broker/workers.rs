//! What workers say, as calls of the broker.

use super::state::Worker;
use super::{Active, Broker, Failure, Loss, ToWorker};
use crate::split::Part;
use gonio_proto::convert::film::FilmShape;
use gonio_proto::convert::task::{AttemptId, Hello};
use gonio_proto::limits;
use gonio_proto::wire::{self, to_worker::Message};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc;

impl Broker {
    /// Adds a worker, and welcomes it; everything for it goes to `outbound`.
    pub fn join(&self, hello: Hello, outbound: mpsc::UnboundedSender<ToWorker>) -> u64 {
        let mut state = self.state();
        let id = state.new_id();
        tracing::info!(worker = id, name = hello.name, slots = hello.slots, "worker joined");
        state.slots += u64::from(hello.slots);
        let worker = Worker {
            hello,
            credits: 0,
            leaving: false,
            held: 0,
            missed: 0,
            outbound,
            told: BTreeMap::new(),
            camera_samples: 0,
            render_time: Duration::ZERO,
        };
        let silence_milliseconds = u32::try_from(self.silence.as_millis()).unwrap_or(u32::MAX);
        worker.send(Message::Welcome(wire::Welcome { worker: id, epoch: self.epoch, silence_milliseconds }));
        state.workers.insert(id, worker);
        state.speeds.join(id);
        id
    }

    /// Removes a worker whose stream has ended, and hands its tasks out again.
    pub fn leave(&self, worker: u64, loss: Loss) {
        let mut state = self.state();
        let Some(name) = state.workers.get(&worker).map(|gone| gone.hello.name.clone()) else { return };
        let returned = state.end_leases(worker, loss, &format!("worker {name} is gone"));
        if let Some(gone) = state.workers.remove(&worker) {
            state.slots -= u64::from(gone.hello.slots);
        }
        state.speeds.leave(worker);
        state.settle(worker);
        state.counters.workers_gone += 1;
        tracing::info!(worker, name, returned, ?loss, "worker gone");
        state.dispatch();
    }

    /// Notes that a worker lives. `false`: there is no such worker.
    pub fn beat(&self, worker: u64, epoch: u64) -> bool {
        let mut state = self.state();
        let Some(beating) = state.workers.get_mut(&worker).filter(|_| epoch == self.epoch) else { return false };
        let was_silent = beating.is_silent();
        beating.missed = 0;
        if was_silent {
            tracing::info!(worker, name = beating.hello.name, "worker is back");
            state.settle(worker);
            state.dispatch();
        }
        true
    }

    /// Adds to a worker's credits.
    pub fn ask(&self, worker: u64, credits: u32) {
        let mut state = self.state();
        let Some(asking) = state.workers.get_mut(&worker) else { return };
        asking.credits = asking.credits.saturating_add(credits).min(limits::CREDITS);
        state.settle(worker);
        state.dispatch();
    }

    /// Notes that a worker stops: it gets no tasks any more.
    pub fn stops(&self, worker: u64) {
        let mut state = self.state();
        let Some(stopping) = state.workers.get_mut(&worker) else { return };
        tracing::info!(worker, name = stopping.hello.name, held = stopping.held, "worker stops");
        stopping.leaving = true;
        state.settle(worker);
    }

    /// Notes that a worker begins to render an attempt, if it holds its lease.
    pub fn start(&self, worker: u64, id: AttemptId) {
        if let Some(entry) = self.state().entry(id) {
            entry.tasks.start(id.task, id.attempt, worker);
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

    /// Accepts an attempt's result, if `worker` holds its lease: then the caller adds the film to the evaluation's
    /// reduction, and other attempts at the task are over. Otherwise the result is late, and refused. `render_time` is
    /// what the worker says that it took.
    #[must_use]
    pub fn commit(&self, worker: u64, id: AttemptId, render_time: Duration) -> Option<(Arc<Active>, Part)> {
        let mut state = self.state();
        let accepted = state.entry(id).and_then(|entry| {
            let part = entry.active.part(id.task)?;
            let committed = entry.tasks.commit(id.task, id.attempt, worker)?;
            let samples = entry.active.split.camera_samples(&part);
            entry.camera_samples += samples;
            // A worker may claim anything, but not more than has passed.
            let render_time = render_time.min(committed.lease.since.elapsed());
            entry.pace.add(samples, render_time);
            Some((Arc::clone(&entry.active), part, samples, render_time, committed))
        });
        let Some((active, part, samples, render_time, committed)) = accepted else {
            drop(state);
            self.refuse(worker, id, false);
            return None;
        };
        state.counters.committed += 1;
        state.counters.camera_samples += samples;
        let took = i64::try_from(render_time.as_micros()).unwrap_or(i64::MAX);
        state.shares.charge(id.evaluation, took.saturating_sub(committed.lease.charged.into()));
        state.let_go(worker, 1);
        state.speeds.add(worker, id.evaluation, samples);
        if let Some(worker) = state.workers.get_mut(&worker) {
            worker.camera_samples += samples;
            worker.render_time += render_time;
            if let Some(pace) = worker.told.get_mut(&id.evaluation) {
                pace.add(samples, render_time);
            }
        }
        for (attempt, loser) in committed.others {
            state.counters.revoked += 1;
            state.let_go(loser, 1);
            if let Some(loser) = state.workers.get(&loser) {
                let attempts = vec![AttemptId { attempt, ..id }.into()];
                loser.send(Message::Revoked(wire::Revoked { attempts }));
            }
        }
        drop(state);
        self.render_times.add(render_time);
        Some((active, part))
    }

    /// Counts a result that is refused: sent twice, foreign, or late.
    pub fn refuse(&self, worker: u64, id: AttemptId, repeated: bool) {
        let mut state = self.state();
        let holder = state.entry(id).and_then(|entry| entry.tasks.holder(id.task, id.attempt));
        let foreign = id.epoch != self.epoch || holder.is_some_and(|holder| holder != worker);
        let why = match (repeated, foreign) {
            (true, _) => "its film was sent before",
            (false, true) => "its lease was never this worker's here",
            (false, false) => "its lease has ended",
        };
        state.counters.refused += 1;
        state.counters.repeated += u64::from(repeated);
        state.counters.foreign += u64::from(foreign && !repeated);
        tracing::info!(worker, %id, why, refused = state.counters.refused, "result refused");
    }

    /// Ends an evaluation whose task no worker can render.
    pub fn fail(&self, worker: u64, id: AttemptId, text: &str) {
        let mut state = self.state();
        let Some(entry) = state.entry(id).filter(|entry| entry.tasks.is_held(id.task, id.attempt, worker)) else {
            return;
        };
        entry.tasks.stop();
        entry.active.end(Err(Failure::of_request(gonio_proto::convert::text(text))));
        state.shares.set_waiting(id.evaluation, false);
    }

    /// Takes a task back from a worker that will not render it, and says why unless it stops.
    pub fn release(&self, worker: u64, id: AttemptId, text: &str) {
        let mut state = self.state();
        if state.entry(id).is_none() {
            return;
        }
        let (loss, why) =
            if text.is_empty() { (Loss::HandedBack, "its worker stops") } else { (Loss::Unfetched, text) };
        state.give_back((id.evaluation, id.task, id.attempt, worker), loss, why);
        state.dispatch();
    }
}
