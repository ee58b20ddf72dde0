//! What happened since the start, for logs and tests.

/// Every number only grows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Leases granted.
    pub granted: u64,
    /// Of these, second attempts at tasks that others took long for.
    pub second: u64,
    /// Commits accepted, one per task.
    pub committed: u64,
    /// Camera samples of the tasks committed.
    pub camera_samples: u64,
    /// Results refused: late, foreign, or sent twice.
    pub refused: u64,
    /// Of these, those of another coordinator's tasks, or of leases that another worker holds.
    pub foreign: u64,
    /// Of these, those sent twice.
    pub repeated: u64,
    /// Leases that ended without a result, for whatever reason.
    pub returned: u64,
    /// Leases that ended because another attempt was faster.
    pub revoked: u64,
    /// Times that a worker fell silent.
    pub silences: u64,
    /// Workers whose stream ended.
    pub workers_gone: u64,
    /// Tasks set aside, each with its evaluation.
    pub set_aside: u64,
}
