//! The broker as somebody who watches sees it: its strength, and workers a page at a time.

use super::Broker;
use super::state::Worker;
use tokio::time::Instant;

/// All workers together.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Strength {
    /// Workers connected.
    pub workers: usize,
    /// Of these, those that do not beat.
    pub silent: usize,
    /// Their render threads.
    pub slots: u64,
    /// Of these, those that have something to render.
    pub busy: u64,
    /// Tasks that workers hold.
    pub leased: u64,
    /// Tasks that wait.
    pub waiting: u64,
    /// Camera samples committed a second, lately.
    pub samples_per_second: f64,
}

/// What a worker does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activity {
    /// It holds tasks.
    Rendering,
    /// It waits for some.
    Idle,
    /// It finishes what it holds, and takes nothing more.
    Leaving,
    /// It does not beat: its tasks are others'.
    Silent,
}

/// One worker.
#[derive(Debug, Clone)]
pub struct WorkerLook {
    /// Its number.
    pub id: u64,
    /// Its name, which others may have, too.
    pub name: String,
    /// What it does.
    pub activity: Activity,
    /// Its render threads.
    pub slots: u32,
    /// Tasks that it holds.
    pub held: u64,
    /// Camera samples that it committed.
    pub samples: u64,
    /// Camera samples a second, lately.
    pub samples_per_second: f64,
    /// Since when it is connected.
    pub since: Instant,
}

impl Worker {
    fn activity(&self) -> Activity {
        match (self.is_silent(), self.leaving, self.held) {
            (true, ..) => Activity::Silent,
            (_, true, _) => Activity::Leaving,
            (_, _, 0) => Activity::Idle,
            _ => Activity::Rendering,
        }
    }
}

impl Broker {
    /// All workers together, and what waits for them.
    #[must_use]
    pub fn look(&self) -> Strength {
        let state = self.state();
        let mut all = Strength {
            workers: state.workers.len(),
            slots: state.slots,
            waiting: state.evaluations.values().map(|entry| entry.tasks.waiting()).sum(),
            samples_per_second: state.speeds.per_second(Instant::now()),
            ..Strength::default()
        };
        for worker in state.workers.values() {
            all.silent += usize::from(worker.is_silent());
            all.busy += worker.held.min(worker.hello.slots.into());
            all.leased += worker.held;
        }
        all
    }

    /// Of the workers whose names contain `find`, by age: how many there are, and `count` of them from the one at `from`.
    #[must_use]
    pub fn look_at_workers(&self, find: &str, from: usize, count: usize) -> (usize, Vec<WorkerLook>) {
        let state = self.state();
        let now = Instant::now();
        let found = || state.workers.iter().filter(|(_, worker)| worker.hello.name.contains(find));
        let look = |(id, worker): (&u64, &Worker)| {
            let speed = state.speeds.of_worker(*id);
            WorkerLook {
                id: *id,
                name: worker.hello.name.clone(),
                activity: worker.activity(),
                slots: worker.hello.slots,
                held: worker.held,
                samples: speed.map_or(0, |speed| speed.samples),
                samples_per_second: speed.map_or(0.0, |speed| speed.per_second(now)),
                since: speed.map_or(now, |speed| speed.since),
            }
        };
        (found().count(), found().skip(from).take(count).map(look).collect())
    }

    /// Camera samples of an evaluation that are committed a second, lately.
    #[must_use]
    pub fn samples_per_second(&self, evaluation: u64) -> f64 {
        self.state().speeds.of_evaluation(evaluation).map_or(0.0, |speed| speed.per_second(Instant::now()))
    }
}
