//! What waits for the render threads, by class: interactive work and batch work take turns by render time, so that
//! neither a fit nor a sweep waits for all that the other has sent here.

use gonio_proto::convert::request::Class;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Render time of interactive work for each of batch work, where both wait: as the coordinator shares the farm.
const INTERACTIVE_WEIGHT: u64 = 4;

type Job = Box<dyn FnOnce() + Send>;

/// A render pool and what waits for it. Clones share both.
#[derive(Clone)]
pub struct Queue {
    pool: Arc<rayon::ThreadPool>,
    /// Held only to put a job in or to take one out.
    waiting: Arc<Mutex<Waiting>>,
}

#[derive(Default)]
struct Waiting {
    /// Interactive, then batch; the first come is the first served.
    jobs: [VecDeque<Job>; 2],
    /// Render time over weight that each class has had, microseconds.
    passes: [u64; 2],
}

impl Queue {
    /// Nothing waits.
    #[must_use]
    pub fn new(pool: rayon::ThreadPool) -> Self {
        Self { pool: Arc::new(pool), waiting: Arc::default() }
    }

    /// Render threads.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Runs a job on a render thread when its turn comes. The job must not panic.
    pub fn push(&self, class: Class, job: impl FnOnce() + Send + 'static) {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner).push(class, Box::new(job));
        let waiting = Arc::clone(&self.waiting);
        // One call per job, which takes whichever job is next by then: the choice is made as late as possible.
        self.pool.spawn(move || run_next(&waiting));
    }
}

fn run_next(waiting: &Mutex<Waiting>) {
    let lock = || waiting.lock().unwrap_or_else(PoisonError::into_inner);
    let Some((class, job)) = lock().pop() else { return };
    let start = Instant::now();
    job();
    lock().charge(class, u64::try_from(start.elapsed().as_micros()).unwrap_or(u64::MAX));
}

impl Waiting {
    fn push(&mut self, class: Class, job: Job) {
        let (own, other) = (class as usize, 1 - class as usize);
        if self.jobs[own].is_empty() && !self.jobs[other].is_empty() {
            // A class does not make up for the time in which it wanted nothing.
            self.passes[own] = self.passes[own].max(self.passes[other]);
        }
        self.jobs[own].push_back(job);
    }

    fn pop(&mut self) -> Option<(Class, Job)> {
        let [interactive, batch] = &mut self.jobs;
        let first = batch.is_empty() || (self.passes[0] <= self.passes[1] && !interactive.is_empty());
        let (class, jobs) = if first { (Class::Interactive, interactive) } else { (Class::Batch, batch) };
        jobs.pop_front().map(|job| (class, job))
    }

    fn charge(&mut self, class: Class, micros: u64) {
        let weight = if class == Class::Interactive { INTERACTIVE_WEIGHT } else { 1 };
        let pass = &mut self.passes[class as usize];
        *pass = pass.saturating_add(micros / weight);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(interactive: usize, batch: usize) -> Waiting {
        let mut waiting = Waiting::default();
        (0..batch).for_each(|_| waiting.push(Class::Batch, Box::new(|| ())));
        (0..interactive).for_each(|_| waiting.push(Class::Interactive, Box::new(|| ())));
        waiting
    }

    /// Takes `count` jobs of 10 ms each; how many were interactive.
    fn take(waiting: &mut Waiting, count: usize) -> usize {
        let take = |_| {
            let (class, _) = waiting.pop().unwrap();
            waiting.charge(class, 10_000);
            usize::from(class == Class::Interactive)
        };
        (0..count).map(take).sum()
    }

    #[test]
    fn classes_take_turns_by_weight() {
        let mut waiting = filled(100, 100);
        assert_eq!(waiting.pop().unwrap().0, Class::Interactive);
        assert_eq!(take(&mut waiting, 50), 40);
    }

    #[test]
    fn interactive_work_that_comes_late_is_next_and_owes_nothing() {
        let mut waiting = filled(0, 200);
        assert_eq!(take(&mut waiting, 50), 0);
        waiting.push(Class::Interactive, Box::new(|| ()));
        assert_eq!(take(&mut waiting, 1), 1);
        // Nor has it saved anything up.
        (0..50).for_each(|_| waiting.push(Class::Interactive, Box::new(|| ())));
        assert!(take(&mut waiting, 25) <= 21);
    }

    #[test]
    fn every_job_runs_once() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let queue = Queue::new(pool);
        let (sender, receiver) = std::sync::mpsc::channel();
        for i in 0..100 {
            let sender = sender.clone();
            let class = if i % 3 == 0 { Class::Batch } else { Class::Interactive };
            queue.push(class, move || sender.send(i).unwrap());
        }
        drop(sender);
        let mut ran: Vec<i32> = receiver.iter().collect();
        ran.sort_unstable();
        assert_eq!(ran, (0..100).collect::<Vec<_>>());
    }
}
