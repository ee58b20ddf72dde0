//! Tasks taken back from whoever has them, because somebody who watches has had enough: of a worker that beats and does not
//! get on.

use super::loss::Loss;
use super::{Broker, wire};
use gonio_proto::convert::task::AttemptId;
use gonio_proto::wire::to_worker::Message;

impl Broker {
    /// Ends all leases of an evaluation and hands its tasks out anew; returns how many. What has been committed stays, and
    /// nothing counts against a task.
    pub fn reissue(&self, evaluation: u64) -> usize {
        let mut state = self.state();
        let Some(entry) = state.evaluations.get(&evaluation) else { return 0 };
        let leases = entry.tasks.leased(|_| true);
        for (task, attempt, worker) in &leases {
            state.give_back((evaluation, *task, *attempt, *worker), Loss::HandedBack, "somebody asked for another try");
            if let Some(holder) = state.workers.get(worker) {
                let id = AttemptId { epoch: self.epoch, evaluation, task: *task, attempt: *attempt };
                holder.send(Message::Revoked(wire::Revoked { attempts: vec![id.into()] }));
            }
        }
        tracing::info!(evaluation, tasks = leases.len(), "handed out anew");
        state.dispatch();
        leases.len()
    }
}
