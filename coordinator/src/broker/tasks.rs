//! The tasks of one evaluation: which wait, which are leased, which are committed.
//!
//! Memory and time are linear in what happens, not in the number of tasks: tasks that nobody has touched yet are no more
//! than a counter.

use std::collections::{BTreeMap, BTreeSet};
use tokio::time::Instant;

/// A worker's right to commit an attempt, until it expires.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lease {
    /// Who holds it.
    pub worker: u64,
    /// When the sweep may take it away.
    pub expires: Instant,
}

/// The state of every task of one evaluation.
#[derive(Debug)]
pub struct Tasks {
    /// Number of tasks.
    total: u64,
    /// The first task that was never handed out; all after it neither.
    untouched: u64,
    /// Tasks that were handed out and came back; they go first, for others wait for their tile.
    returned: BTreeSet<u64>,
    /// Live attempts by task and attempt. Granted by [`Tasks::take`], renewed by their worker, ended by its commit,
    /// failure or loss, or by the sweep.
    leases: BTreeMap<(u64, u32), Lease>,
    /// Attempts that ended without a commit, of tasks that had any.
    lost_attempts: BTreeMap<u64, u32>,
    /// One bit per task: set by the first valid commit, never cleared.
    committed: Vec<u64>,
    /// Number of bits set.
    done: u64,
}

impl Tasks {
    /// `total` tasks, all untouched.
    #[must_use]
    pub fn new(total: u64) -> Self {
        Self {
            total,
            untouched: 0,
            returned: BTreeSet::new(),
            leases: BTreeMap::new(),
            lost_attempts: BTreeMap::new(),
            committed: vec![0; total.div_ceil(64) as usize],
            done: 0,
        }
    }

    /// Whether a task waits to be handed out.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        !self.returned.is_empty() || self.untouched < self.total
    }

    /// Tasks committed, and tasks in all.
    #[must_use]
    pub fn done(&self) -> (u64, u64) {
        (self.done, self.total)
    }

    /// Leases the next task to a worker: its index and attempt.
    pub fn take(&mut self, lease: Lease) -> Option<(u64, u32)> {
        let task = match self.returned.pop_first() {
            Some(task) => task,
            None if self.untouched < self.total => {
                self.untouched += 1;
                self.untouched - 1
            }
            None => return None,
        };
        let attempt = self.lost_attempts.get(&task).copied().unwrap_or(0);
        self.leases.insert((task, attempt), lease);
        Some((task, attempt))
    }

    /// Whether `worker` holds the lease of this attempt.
    #[must_use]
    pub fn is_held(&self, task: u64, attempt: u32, worker: u64) -> bool {
        self.leases.get(&(task, attempt)).is_some_and(|lease| lease.worker == worker)
    }

    /// Extends a lease; does nothing if `worker` does not hold it.
    pub fn renew(&mut self, task: u64, attempt: u32, lease: Lease) {
        if let Some(held) = self.leases.get_mut(&(task, attempt)).filter(|held| held.worker == lease.worker) {
            *held = lease;
        }
    }

    /// Commits an attempt. `false`: its lease has ended or was never `worker`'s, or the task is committed already; then
    /// nothing changes.
    pub fn commit(&mut self, task: u64, attempt: u32, worker: u64) -> bool {
        let (word, bit) = ((task / 64) as usize, 1 << (task % 64));
        if !self.is_held(task, attempt, worker) || self.committed[word] & bit != 0 {
            return false;
        }
        self.leases.remove(&(task, attempt));
        self.lost_attempts.remove(&task);
        self.committed[word] |= bit;
        self.done += 1;
        true
    }

    /// Ends an attempt without a result and puts its task back. Returns how many attempts the task has lost, or `None`
    /// if `worker` does not hold the lease.
    pub fn give_back(&mut self, task: u64, attempt: u32, worker: u64) -> Option<u32> {
        if !self.is_held(task, attempt, worker) {
            return None;
        }
        self.leases.remove(&(task, attempt));
        self.returned.insert(task);
        let lost = self.lost_attempts.entry(task).or_default();
        *lost += 1;
        Some(*lost)
    }

    /// The leases that a predicate picks: task, attempt and worker.
    pub fn leased(&self, pick: impl Fn(&Lease) -> bool) -> Vec<(u64, u32, u64)> {
        let picked = self.leases.iter().filter(|(_, lease)| pick(lease));
        picked.map(|((task, attempt), lease)| (*task, *attempt, lease.worker)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn lease(worker: u64) -> Lease {
        Lease { worker, expires: Instant::now() + Duration::from_secs(1) }
    }

    #[test]
    fn tasks_are_handed_out_once_in_order_and_returned_ones_first() {
        let mut tasks = Tasks::new(3);
        assert_eq!(tasks.take(lease(1)), Some((0, 0)));
        assert_eq!(tasks.take(lease(2)), Some((1, 0)));
        assert_eq!(tasks.give_back(0, 0, 1), Some(1));
        assert_eq!(tasks.take(lease(2)), Some((0, 1)));
        assert_eq!(tasks.take(lease(2)), Some((2, 0)));
        assert_eq!(tasks.take(lease(2)), None);
        assert!(!tasks.is_ready());
    }

    #[test]
    fn only_the_holder_of_a_live_lease_commits_and_once() {
        let mut tasks = Tasks::new(70);
        while tasks.take(lease(1)).is_some() {}
        assert!(!tasks.commit(69, 0, 2), "another worker's lease");
        assert!(!tasks.commit(69, 1, 1), "an attempt that was never made");
        assert!(!tasks.commit(u64::MAX, 0, 1), "a task that does not exist");
        assert!(tasks.commit(69, 0, 1));
        assert!(!tasks.commit(69, 0, 1), "twice");
        assert_eq!(tasks.done(), (1, 70));
        tasks.give_back(3, 0, 1).unwrap();
        assert!(!tasks.commit(3, 0, 1), "a lease that has ended");
        assert_eq!(tasks.give_back(3, 0, 1), None);
    }

    #[test]
    fn a_lease_is_renewed_by_its_holder_only() {
        let mut tasks = Tasks::new(1);
        let start = Instant::now();
        let until = |worker, seconds| Lease { worker, expires: start + Duration::from_secs(seconds) };
        tasks.take(until(1, 10));
        let expired =
            |tasks: &Tasks, seconds| !tasks.leased(|l| l.expires <= start + Duration::from_secs(seconds)).is_empty();
        tasks.renew(0, 0, until(2, 99));
        assert!(expired(&tasks, 10));
        tasks.renew(0, 0, until(1, 20));
        assert!(!expired(&tasks, 19) && expired(&tasks, 20));
    }
}
