//! What waits for the render threads, by class: interactive work and batch work take turns by render time, so that
//! neither a fit nor a sweep waits for all that the other has sent here.

use gonio_proto::convert::request::Class;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

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
    /// Threads that run a job.
    running: usize,
    /// When a job last came to where none waited, was begun, or ended.
    moved: Option<Instant>,
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

    /// Jobs that run, and jobs that wait.
    #[must_use]
    pub fn load(&self) -> (u64, u64) {
        let waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        (waiting.running as u64, waiting.len() as u64)
    }

    /// Whether jobs wait that no thread has begun for `bound` although threads are free: long jobs keep them busy, a hang
    /// does not.
    #[must_use]
    pub fn is_stuck(&self, bound: Duration) -> bool {
        let waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        let still = waiting.moved.is_some_and(|moved| moved.elapsed() > bound);
        waiting.len() > 0 && waiting.running < self.threads() && still
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
    fn len(&self) -> usize {
        self.jobs.iter().map(VecDeque::len).sum()
    }

    fn push(&mut self, class: Class, job: Job) {
        if self.len() == 0 {
            self.moved = Some(Instant::now());
        }
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
        let job = jobs.pop_front()?;
        self.running += 1;
        self.moved = Some(Instant::now());
        Some((class, job))
    }

    /// Notes that a job has ended, and what it took.
    fn charge(&mut self, class: Class, micros: u64) {
        self.running -= 1;
        self.moved = Some(Instant::now());
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
    fn long_jobs_are_no_hang_and_jobs_that_no_free_thread_begins_are() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let queue = Queue::new(pool);
        let (bound, (end, ended)) = (Duration::from_millis(50), std::sync::mpsc::channel::<()>());
        queue.push(Class::Batch, move || ended.recv().unwrap());
        queue.push(Class::Batch, || ());
        std::thread::sleep(3 * bound);
        assert_eq!((queue.load(), queue.is_stuck(bound)), ((1, 1), false), "the thread is busy");
        end.send(()).unwrap();
        while queue.load() != (0, 0) {
            std::thread::yield_now();
        }
        assert!(!queue.is_stuck(Duration::ZERO), "nothing waits");
        // A job without the call that takes it: what a lost thread would leave.
        queue.waiting.lock().unwrap().push(Class::Batch, Box::new(|| ()));
        assert!(!queue.is_stuck(bound));
        std::thread::sleep(3 * bound);
        assert!(queue.is_stuck(bound));
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
