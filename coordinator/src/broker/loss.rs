//! How attempts are lost, and when a task is taken for the cause.
//!
//! A process that dies leaves a connection that ends; a machine or a network that goes leaves silence. Only what was being
//! rendered on a process that died is a suspect: what waited there is not, nor is anything on a machine that was lost.

/// Worker processes that may die while they render one task. The third death is no accident.
pub const MOST_DEATHS: u32 = 3;

/// Times that one task may be lost otherwise: to silence while it was being rendered, to blobs that cannot be fetched, to
/// workers that break the protocol. Farms lose machines, but none so many to one task by chance; and an evaluation must end.
pub const MOST_LOSSES: u32 = 16;

/// How an attempt ended without a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loss {
    /// Its worker stops, and said so.
    HandedBack,
    /// Its worker could not fetch the capture.
    Unfetched,
    /// Its worker does not beat: machine or network is gone, or the process is paused.
    Silent,
    /// Its worker's stream broke: the process died.
    Died,
    /// Its worker broke the protocol and was sent away.
    Banned,
}

/// What a task has been through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct History {
    /// Number of the next attempt.
    pub next_attempt: u32,
    /// Workers that died while they rendered it.
    pub deaths: u32,
    /// Attempts lost otherwise, those not counted that say nothing about the task.
    pub losses: u32,
}

impl History {
    pub(super) fn add(&mut self, loss: Loss, rendering: bool) {
        match loss {
            Loss::HandedBack => {}
            Loss::Unfetched => self.losses += 1,
            Loss::Died if rendering => self.deaths += 1,
            Loss::Silent | Loss::Banned if rendering => self.losses += 1,
            Loss::Died | Loss::Silent | Loss::Banned => {}
        }
    }

    /// Whether the task may be handed out again.
    #[must_use]
    pub fn is_bearable(&self) -> bool {
        self.deaths < MOST_DEATHS && self.losses < MOST_LOSSES
    }

    /// Why a task is set aside, for people; `task` describes it, `last` says how the last attempt ended.
    #[must_use]
    pub fn verdict(&self, task: &str, last: &str) -> String {
        if self.deaths >= MOST_DEATHS {
            let deaths = self.deaths;
            return format!(
                "{task} is set aside: {deaths} workers died while they rendered it, at last {last}; see their logs and memory limits"
            );
        }
        format!("{task} is set aside: it was lost {} times, at last {last}", self.losses)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_rendered_by_a_process_that_died_is_a_suspect() {
        let mut history = History::default();
        for _ in 0..100 {
            history.add(Loss::Died, false);
            history.add(Loss::Silent, false);
            history.add(Loss::HandedBack, true);
        }
        assert_eq!(history, History::default());
        for _ in 1..MOST_DEATHS {
            history.add(Loss::Died, true);
        }
        assert!(history.is_bearable());
        history.add(Loss::Silent, true);
        assert!(history.is_bearable(), "a lost machine is no death");
        history.add(Loss::Died, true);
        assert!(!history.is_bearable());
        let text = history.verdict("task 7", "worker b is gone");
        assert!(text.starts_with("task 7 is set aside: 3 workers died") && text.contains("worker b is gone"), "{text}");
    }

    #[test]
    fn losses_of_any_other_kind_end_at_a_higher_bound() {
        let mut history = History::default();
        for loss in 0..MOST_LOSSES {
            assert!(history.is_bearable(), "{loss}");
            history.add(if loss % 2 == 0 { Loss::Silent } else { Loss::Unfetched }, true);
        }
        assert!(!history.is_bearable());
        assert!(history.verdict("task 7", "silence").contains("was lost 16 times"));
    }
}
