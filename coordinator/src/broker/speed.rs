//! How fast camera samples come in: of each worker, and of each evaluation.

use std::collections::BTreeMap;
use tokio::time::Instant;

/// How long what has come counts, in seconds: a sample's weight falls to 1/e in this time.
const MEMORY: f64 = 5.0;

/// Camera samples committed, and how many a second lately.
#[derive(Debug, Clone, Copy)]
pub struct Speed {
    /// From when on it is counted.
    pub since: Instant,
    /// All so far.
    pub samples: u64,
    /// Weighted by their age at `at`.
    recent: f64,
    at: Instant,
}

impl Speed {
    fn new(now: Instant) -> Self {
        Self { since: now, samples: 0, recent: 0.0, at: now }
    }

    fn add(&mut self, samples: u64, now: Instant) {
        #[allow(clippy::cast_precision_loss)]
        let more = samples as f64;
        self.recent = self.recent * self.decay(now) + more;
        (self.samples, self.at) = (self.samples.saturating_add(samples), now);
    }

    fn decay(&self, now: Instant) -> f64 {
        libm::exp(-now.saturating_duration_since(self.at).as_secs_f64() / MEMORY)
    }

    /// Camera samples a second, over about the last [`MEMORY`].
    #[must_use]
    pub fn per_second(&self, now: Instant) -> f64 {
        // Of what has just begun, the memory is no longer than its age; but not so short that one commit is a flood.
        let age = now.saturating_duration_since(self.since).as_secs_f64().max(0.5);
        self.recent * self.decay(now) / (MEMORY * (1.0 - libm::exp(-age / MEMORY)))
    }
}

/// The speeds of all that is there.
#[derive(Debug, Default)]
pub(super) struct Speeds {
    workers: BTreeMap<u64, Speed>,
    evaluations: BTreeMap<u64, Speed>,
}

impl Speeds {
    /// A worker is there from now on.
    pub fn join(&mut self, worker: u64) {
        self.workers.insert(worker, Speed::new(Instant::now()));
    }

    /// A worker is gone.
    pub fn leave(&mut self, worker: u64) {
        self.workers.remove(&worker);
    }

    /// An evaluation is over.
    pub fn end(&mut self, evaluation: u64) {
        self.evaluations.remove(&evaluation);
    }

    /// A worker has committed so many camera samples of an evaluation.
    pub fn add(&mut self, worker: u64, evaluation: u64, samples: u64) {
        let now = Instant::now();
        if let Some(speed) = self.workers.get_mut(&worker) {
            speed.add(samples, now);
        }
        self.evaluations.entry(evaluation).or_insert_with(|| Speed::new(now)).add(samples, now);
    }

    pub fn of_worker(&self, worker: u64) -> Option<Speed> {
        self.workers.get(&worker).copied()
    }

    pub fn of_evaluation(&self, evaluation: u64) -> Option<Speed> {
        self.evaluations.get(&evaluation).copied()
    }

    /// Of all workers together, a second.
    pub fn per_second(&self, now: Instant) -> f64 {
        self.workers.values().map(|speed| speed.per_second(now)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[tokio::test(start_paused = true)]
    async fn a_steady_worker_has_its_speed_and_an_idle_one_soon_none() {
        let mut speeds = Speeds::default();
        speeds.join(1);
        for _ in 0..200 {
            tokio::time::advance(Duration::from_millis(100)).await;
            speeds.add(1, 7, 1000);
        }
        for speed in [speeds.of_worker(1), speeds.of_evaluation(7)] {
            let measured = speed.unwrap().per_second(Instant::now());
            assert!((measured / 10_000.0 - 1.0).abs() < 0.05, "{measured}");
        }
        assert_eq!(speeds.of_worker(1).unwrap().samples, 200_000);
        tokio::time::advance(Duration::from_secs(60)).await;
        assert!(speeds.per_second(Instant::now()) < 1.0);
        speeds.leave(1);
        speeds.end(7);
        assert!(speeds.of_worker(1).is_none() && speeds.of_evaluation(7).is_none());
    }

    #[tokio::test(start_paused = true)]
    async fn a_first_commit_is_no_flood() {
        let mut speeds = Speeds::default();
        speeds.join(1);
        speeds.add(1, 7, 1000);
        let measured = speeds.of_worker(1).unwrap().per_second(Instant::now());
        assert!((1900.0..2200.0).contains(&measured), "{measured}");
    }
}
