//! The broker seen from outside, at one moment.

use super::state::State;
use super::{Broker, Counters};
use std::collections::BTreeMap;
use std::time::Duration;

/// What there is to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Load {
    /// Tasks that wait to be handed out.
    pub queued: u64,
    /// Attempts that workers hold.
    pub leased: u64,
}

impl Load {
    /// Queued and leased together.
    #[must_use]
    pub fn tasks(self) -> u64 {
        self.queued + self.leased
    }
}

/// What workers of one name have done since they connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WorkerSurvey {
    /// Camera samples of the tasks that they committed.
    pub camera_samples: u64,
    /// What these took, of one render thread.
    pub render_time: Duration,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Survey {
    /// What happened so far.
    pub counters: Counters,
    /// What there is to do.
    pub load: Load,
    /// Evaluations that are being rendered.
    pub evaluations: u64,
    /// Workers connected.
    pub connected: u64,
    /// Of these, those that do not beat.
    pub silent: u64,
    /// Render threads of those connected.
    pub slots: u64,
    /// By name, those that connected first of all that are there.
    pub workers: BTreeMap<String, WorkerSurvey>,
}

impl Broker {
    /// What there is to do.
    #[must_use]
    pub fn load(&self) -> Load {
        load(&self.state())
    }

    /// The broker as it is now, with at most `most` names of workers.
    #[must_use]
    pub fn survey(&self, most: usize) -> Survey {
        let state = self.state();
        let mut survey = Survey {
            counters: state.counters,
            load: load(&state),
            evaluations: state.evaluations.len() as u64,
            connected: state.workers.len() as u64,
            slots: state.slots,
            ..Survey::default()
        };
        for worker in state.workers.values() {
            survey.silent += u64::from(worker.is_silent());
            let known = survey.workers.contains_key(&worker.hello.name);
            if known || survey.workers.len() < most {
                let of_name = survey.workers.entry(worker.hello.name.clone()).or_default();
                of_name.camera_samples += worker.camera_samples;
                of_name.render_time += worker.render_time;
            }
        }
        survey
    }

    /// Holds the lock for as long as a test wants.
    #[cfg(test)]
    pub(crate) fn hang(&self) -> impl Sized + '_ {
        self.state()
    }
}

fn load(state: &State) -> Load {
    let mut load = Load::default();
    for entry in state.evaluations.values() {
        load.queued += entry.tasks.waiting();
        load.leased += entry.tasks.in_hand();
    }
    load
}
