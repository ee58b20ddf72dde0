//! The tasks of one evaluation: which wait, which are leased, which are committed.
//!
//! Memory and time are linear in what happens, not in the number of tasks: tasks that nobody has touched yet are no more
//! than a counter.

use super::loss::{History, Loss};
use std::collections::{BTreeMap, BTreeSet};
use tokio::time::Instant;

/// A worker's right to commit an attempt. It lasts until the worker commits, gives back, goes or falls silent, or until
/// another attempt commits the task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lease {
    /// Who holds it.
    pub worker: u64,
    /// When it was granted; from [`Tasks::start`] on, when the rendering began.
    pub since: Instant,
    /// Whether the worker has begun to render.
    pub rendering: bool,
    /// What the client was charged for it in advance, microseconds of one render thread.
    pub charged: u32,
}

/// What a commit has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Committed {
    /// The lease of the attempt that was committed.
    pub lease: Lease,
    /// The other attempts at the task, over now, and who made them.
    pub others: Vec<(u32, u64)>,
}

/// The state of every task of one evaluation.
#[derive(Debug)]
pub struct Tasks {
    /// Number of tasks.
    total: u64,
    /// The first task that was never handed out and is not committed; none after it was handed out.
    untouched: u64,
    /// Tasks after `untouched` that are committed all the same: by an earlier coordinator.
    restored: u64,
    /// Tasks that were handed out and came back; they go first, for others wait for their tile.
    returned: BTreeSet<u64>,
    /// Live attempts by task and attempt. Granted by [`Tasks::take`] and [`Tasks::second`], ended by a commit of their
    /// task or by [`Tasks::give_back`].
    leases: BTreeMap<(u64, u32), Lease>,
    /// Of tasks with more than a first attempt, or a lost one, until they are committed.
    histories: BTreeMap<u64, History>,
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
            restored: 0,
            returned: BTreeSet::new(),
            leases: BTreeMap::new(),
            histories: BTreeMap::new(),
            committed: vec![0; total.div_ceil(64) as usize],
            done: 0,
        }
    }

    /// Commits a task that was committed to an earlier coordinator, before any is handed out.
    pub fn restore(&mut self, task: u64) {
        if task < self.total && !self.is_committed(task) {
            self.committed[(task / 64) as usize] |= 1 << (task % 64);
            self.done += 1;
            self.restored += 1;
            self.skip();
        }
    }

    fn is_committed(&self, task: u64) -> bool {
        self.committed[(task / 64) as usize] & (1 << (task % 64)) != 0
    }

    /// Passes tasks that nobody need be handed.
    fn skip(&mut self) {
        while self.restored > 0 && self.untouched < self.total && self.is_committed(self.untouched) {
            self.untouched += 1;
            self.restored -= 1;
        }
    }

    /// Tasks that wait to be handed out.
    #[must_use]
    pub fn waiting(&self) -> u64 {
        self.returned.len() as u64 + self.total - self.untouched - self.restored
    }

    /// Tasks committed, and tasks in all.
    #[must_use]
    pub fn done(&self) -> (u64, u64) {
        (self.done, self.total)
    }

    /// The next task to be handed out.
    #[must_use]
    pub fn next(&self) -> Option<u64> {
        self.returned.first().copied().or_else(|| (self.untouched < self.total).then_some(self.untouched))
    }

    /// Leases the next task to a worker: its index and attempt.
    pub fn take(&mut self, lease: Lease) -> Option<(u64, u32)> {
        let task = self.next()?;
        if !self.returned.remove(&task) {
            self.untouched += 1;
            self.skip();
        }
        let attempt = self.histories.get(&task).map_or(0, |history| history.next_attempt);
        self.leases.insert((task, attempt), lease);
        Some((task, attempt))
    }

    /// Leases a task that another worker holds: its attempt. Whoever commits first ends the other.
    pub fn second(&mut self, task: u64, lease: Lease) -> Option<u32> {
        let (_, last) = *self.attempts(task).last()?.0;
        let history = self.histories.entry(task).or_default();
        let attempt = history.next_attempt.max(last + 1);
        history.next_attempt = attempt + 1;
        self.leases.insert((task, attempt), lease);
        Some(attempt)
    }

    /// Hands out nothing any more: the evaluation has failed.
    pub fn stop(&mut self) {
        self.returned.clear();
        (self.untouched, self.restored) = (self.total, 0);
    }

    fn attempts(&self, task: u64) -> std::collections::btree_map::Range<'_, (u64, u32), Lease> {
        self.leases.range((task, 0)..=(task, u32::MAX))
    }

    /// Whether `worker` holds the lease of this attempt.
    #[must_use]
    pub fn is_held(&self, task: u64, attempt: u32, worker: u64) -> bool {
        self.holder(task, attempt) == Some(worker)
    }

    /// Who holds the lease of this attempt.
    #[must_use]
    pub fn holder(&self, task: u64, attempt: u32) -> Option<u64> {
        self.leases.get(&(task, attempt)).map(|lease| lease.worker)
    }

    /// Live attempts.
    #[must_use]
    pub fn in_hand(&self) -> u64 {
        self.leases.len() as u64
    }

    /// Notes that the holder of a lease begins to render; does nothing if `worker` does not hold it.
    pub fn start(&mut self, task: u64, attempt: u32, worker: u64) {
        if let Some(held) = self.leases.get_mut(&(task, attempt)).filter(|held| held.worker == worker) {
            (held.rendering, held.since) = (true, Instant::now());
        }
    }

    /// Commits an attempt. `None`: its lease has ended or was never `worker`'s; then nothing changes.
    pub fn commit(&mut self, task: u64, attempt: u32, worker: u64) -> Option<Committed> {
        if !self.is_held(task, attempt, worker) {
            return None;
        }
        let lease = self.leases.remove(&(task, attempt))?;
        let others: Vec<_> = self.attempts(task).map(|((_, attempt), lease)| (*attempt, lease.worker)).collect();
        for (other, _) in &others {
            self.leases.remove(&(task, *other));
        }
        self.histories.remove(&task);
        let (word, bit) = ((task / 64) as usize, 1 << (task % 64));
        // Only leases of tasks without a commit live, so this bit is new.
        debug_assert_eq!(self.committed[word] & bit, 0);
        self.committed[word] |= bit;
        self.done += 1;
        Some(Committed { lease, others })
    }

    /// Ends an attempt without a result. Its task waits again, unless another attempt lives or it has been lost too
    /// often. Returns what the task has been through, or `None` if `worker` does not hold the lease.
    pub fn give_back(&mut self, task: u64, attempt: u32, worker: u64, loss: Loss) -> Option<History> {
        if !self.is_held(task, attempt, worker) {
            return None;
        }
        let lease = self.leases.remove(&(task, attempt))?;
        let history = self.histories.entry(task).or_default();
        history.next_attempt = history.next_attempt.max(attempt + 1);
        history.add(loss, lease.rendering);
        let history = *history;
        if history.is_bearable() && self.attempts(task).next().is_none() {
            self.returned.insert(task);
        }
        Some(history)
    }

    /// The leases that a predicate picks: task, attempt and worker.
    pub fn leased(&self, pick: impl Fn(&Lease) -> bool) -> Vec<(u64, u32, u64)> {
        let picked = self.leases.iter().filter(|(_, lease)| pick(lease));
        picked.map(|((task, attempt), lease)| (*task, *attempt, lease.worker)).collect()
    }

    /// Tasks with a single attempt that has taken since before `before`: since when, and whose. The longest comes first.
    #[must_use]
    pub fn stragglers(&self, before: Instant) -> Vec<(Instant, u64, u64)> {
        let old = self.leases.iter().filter(|(_, lease)| lease.since < before);
        let alone = old.filter(|((task, _), _)| self.attempts(*task).count() == 1);
        let mut stragglers: Vec<_> = alone.map(|((task, _), lease)| (lease.since, *task, lease.worker)).collect();
        stragglers.sort_unstable();
        stragglers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn lease(worker: u64) -> Lease {
        Lease { worker, since: Instant::now(), rendering: false, charged: 0 }
    }

    #[test]
    fn tasks_are_handed_out_once_in_order_and_returned_ones_first() {
        let mut tasks = Tasks::new(3);
        assert_eq!(tasks.take(lease(1)), Some((0, 0)));
        assert_eq!(tasks.take(lease(2)), Some((1, 0)));
        assert_eq!(tasks.waiting(), 1);
        tasks.give_back(0, 0, 1, Loss::HandedBack).unwrap();
        assert_eq!((tasks.waiting(), tasks.next()), (2, Some(0)));
        assert_eq!(tasks.take(lease(2)), Some((0, 1)));
        assert_eq!(tasks.take(lease(2)), Some((2, 0)));
        assert_eq!(tasks.take(lease(2)), None);
        assert_eq!(tasks.waiting(), 0);
    }

    #[test]
    fn what_an_earlier_coordinator_committed_is_not_handed_out() {
        let mut tasks = Tasks::new(6);
        [1, 4, 5, 4, 9].into_iter().for_each(|task| tasks.restore(task));
        assert_eq!((tasks.done(), tasks.waiting()), ((3, 6), 3));
        let taken: Vec<_> = std::iter::from_fn(|| tasks.take(lease(1))).collect();
        assert_eq!((taken, tasks.waiting()), (vec![(0, 0), (2, 0), (3, 0)], 0));
        for task in [3, 0, 2] {
            assert!(tasks.commit(task, 0, 1).is_some());
        }
        assert_eq!((tasks.done(), tasks.next()), ((6, 6), None));
        let mut all = Tasks::new(2);
        [0, 1].into_iter().for_each(|task| all.restore(task));
        assert_eq!((all.waiting(), all.next()), (0, None));
    }

    #[test]
    fn only_the_holder_of_a_live_lease_commits_and_once() {
        let mut tasks = Tasks::new(70);
        while tasks.take(lease(1)).is_some() {}
        assert_eq!(tasks.commit(69, 0, 2), None, "another worker's lease");
        assert_eq!(tasks.commit(69, 1, 1), None, "an attempt that was never made");
        assert_eq!(tasks.commit(u64::MAX, 0, 1), None, "a task that does not exist");
        assert!(tasks.commit(69, 0, 1).is_some());
        assert_eq!(tasks.commit(69, 0, 1), None, "twice");
        assert_eq!(tasks.done(), (1, 70));
        tasks.give_back(3, 0, 1, Loss::Silent).unwrap();
        assert_eq!(tasks.commit(3, 0, 1), None, "a lease that has ended");
        assert_eq!(tasks.give_back(3, 0, 1, Loss::Silent), None);
    }

    #[test]
    fn the_first_of_two_attempts_ends_the_other() {
        let mut tasks = Tasks::new(2);
        let start = Instant::now();
        for worker in [1, 2] {
            tasks.take(Lease { since: start + Duration::from_secs(worker), ..lease(worker) });
        }
        let stragglers = |tasks: &Tasks, seconds| -> Vec<(u64, u64)> {
            let found = tasks.stragglers(start + Duration::from_secs(seconds));
            found.into_iter().map(|(_, task, worker)| (task, worker)).collect()
        };
        assert_eq!(stragglers(&tasks, 2), [(0, 1)]);
        assert_eq!(stragglers(&tasks, 3), [(0, 1), (1, 2)]);
        assert_eq!(tasks.second(0, lease(2)), Some(1));
        assert_eq!(stragglers(&tasks, 3), [(1, 2)], "nobody tries a third time");
        assert_eq!(tasks.commit(0, 1, 2).unwrap().others, [(0, 1)]);
        assert_eq!((tasks.commit(0, 0, 1), tasks.done()), (None, (1, 2)));
        // And of two that are lost, the last puts the task back.
        assert_eq!(tasks.second(1, lease(1)), Some(1));
        tasks.give_back(1, 0, 2, Loss::Silent).unwrap();
        assert_eq!(tasks.next(), None);
        tasks.give_back(1, 1, 1, Loss::Silent).unwrap();
        assert_eq!(tasks.take(lease(3)), Some((1, 2)));
    }

    #[test]
    fn a_task_that_is_not_bearable_is_not_handed_out_again() {
        let mut tasks = Tasks::new(1);
        for deaths in 1..=super::super::loss::MOST_DEATHS {
            let (task, attempt) = tasks.take(lease(1)).unwrap();
            tasks.start(task, attempt, 1);
            assert_eq!(tasks.give_back(task, attempt, 1, Loss::Died).unwrap().deaths, deaths);
        }
        assert_eq!(tasks.next(), None);
    }
}
