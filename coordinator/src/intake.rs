//! Which evaluations run, and the end of taking any.

use std::sync::Arc;
use tokio::sync::watch;

/// Counts evaluations under way. Clones share the count.
#[derive(Debug, Clone)]
pub struct Intake {
    /// Written by [`Intake::enter`], by the turns' end and by [`Intake::close`]; [`Intake::empty`] waits for it.
    state: Arc<watch::Sender<State>>,
}

#[derive(Debug, Clone, Copy, Default)]
struct State {
    closed: bool,
    cut: bool,
    running: usize,
}

/// An evaluation under way; dropped, it is over.
#[derive(Debug)]
pub struct Turn(Intake);

impl Default for Intake {
    fn default() -> Self {
        Self { state: Arc::new(watch::Sender::new(State::default())) }
    }
}

impl Intake {
    /// Counts an evaluation, unless none are taken any more.
    #[must_use]
    pub fn enter(&self) -> Option<Turn> {
        let taken = self.state.send_if_modified(|state| {
            state.running += usize::from(!state.closed);
            !state.closed
        });
        taken.then(|| Turn(self.clone()))
    }

    /// Takes no evaluation any more.
    pub fn close(&self) {
        self.state.send_modify(|state| state.closed = true);
    }

    /// Leaves evaluations that outlive this coordinator to the next one.
    pub fn leave(&self) {
        self.state.send_modify(|state| state.cut = true);
    }

    /// Completes when evaluations are left to the next coordinator.
    pub async fn cut(&self) {
        // The sender lives as long as `self`.
        let _ = self.state.subscribe().wait_for(|state| state.cut).await;
    }

    /// Completes when no evaluation is under way.
    pub async fn empty(&self) {
        // The sender lives as long as `self`.
        let _ = self.state.subscribe().wait_for(|state| state.running == 0).await;
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        self.0.state.send_modify(|state| state.running -= 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures::FutureExt;

    #[tokio::test]
    async fn closed_it_takes_none_and_is_empty_when_the_last_has_ended() {
        let intake = Intake::default();
        let (first, second) = (intake.enter().unwrap(), intake.enter().unwrap());
        intake.close();
        assert!(intake.enter().is_none());
        drop(first);
        assert!(intake.empty().now_or_never().is_none());
        drop(second);
        assert!(intake.empty().now_or_never().is_some());
    }
}
