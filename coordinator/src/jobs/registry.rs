//! All evaluations that run.

use super::Job;
use gonio_proto::Key;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Evaluations that run at the same time: each holds photos and films that no client should fill the memory with.
pub const MOST: usize = 4096;

/// Evaluations by number and by key. Clones share them.
#[derive(Debug, Clone, Default)]
pub struct Jobs {
    /// Held for microseconds; never across an await.
    state: Arc<Mutex<State>>,
}

#[derive(Debug, Default)]
struct State {
    /// Added by [`Jobs::add`], removed by [`Jobs::remove`].
    by_number: BTreeMap<u64, Arc<Job>>,
    by_key: BTreeMap<Key, u64>,
}

impl Jobs {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an evaluation, unless one with its key runs: then that one is returned as the error.
    ///
    /// # Errors
    /// The evaluation that has the key.
    pub fn add(&self, job: Job) -> Result<Arc<Job>, Arc<Job>> {
        let mut state = self.state();
        if let Some(there) =
            job.key.and_then(|key| state.by_key.get(&key)).and_then(|number| state.by_number.get(number))
        {
            return Err(Arc::clone(there));
        }
        let job = Arc::new(job);
        state.by_number.insert(job.evaluation, Arc::clone(&job));
        if let Some(key) = job.key {
            state.by_key.insert(key, job.evaluation);
        }
        Ok(job)
    }

    /// Whether no further evaluation is taken; one whose key runs is no further one.
    #[must_use]
    pub fn is_full_for(&self, key: Option<Key>) -> bool {
        let state = self.state();
        state.by_number.len() >= MOST && key.is_none_or(|key| !state.by_key.contains_key(&key))
    }

    /// Removes an evaluation that is over.
    pub fn remove(&self, job: &Job) {
        let mut state = self.state();
        state.by_number.remove(&job.evaluation);
        if let Some(key) = job.key {
            state.by_key.remove(&key);
        }
    }

    /// The one with a number.
    #[must_use]
    pub fn get(&self, evaluation: u64) -> Option<Arc<Job>> {
        self.state().by_number.get(&evaluation).cloned()
    }

    /// All of them, in the order in which they came.
    #[must_use]
    pub fn all(&self) -> Vec<Arc<Job>> {
        self.state().by_number.values().cloned().collect()
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.state().by_number.len()
    }

    /// Cancels the one with a key, or those of a client; returns how many.
    #[must_use]
    pub fn cancel(&self, key: Option<Key>, client: &str, why: &str) -> u32 {
        let meant = |job: &Arc<Job>| match key {
            Some(key) => job.key == Some(key),
            None => !client.is_empty() && job.requester.client == client,
        };
        let meant: Vec<_> = self.all().into_iter().filter(meant).collect();
        meant.iter().for_each(|job| job.cancel(why));
        meant.len() as u32
    }
}
