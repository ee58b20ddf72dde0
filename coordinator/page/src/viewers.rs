//! Who looks now.

use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;

/// Pages that may follow at the same time: each costs a state twice a second.
pub const MOST: usize = 64;

/// The pages that follow. Clones count the same ones.
#[derive(Debug, Clone)]
pub struct Viewers(Arc<watch::Sender<usize>>);

/// The place of one page; free again once this is dropped.
#[derive(Debug)]
pub(crate) struct Seat(Arc<watch::Sender<usize>>);

impl Default for Viewers {
    fn default() -> Self {
        Self(Arc::new(watch::Sender::new(0)))
    }
}

impl Viewers {
    /// Pages that follow now.
    #[must_use]
    pub fn count(&self) -> usize {
        *self.0.borrow()
    }

    /// Completes when nobody follows any more, or after `patience`.
    pub async fn gone(&self, patience: Duration) {
        let mut count = self.0.subscribe();
        // The sender lives as long as `self`; patience that runs out is as good.
        let _ = tokio::time::timeout(patience, count.wait_for(|count| *count == 0)).await;
    }

    /// A place for one more; `None` where all are taken.
    pub(crate) fn enter(&self) -> Option<Seat> {
        let entered = self.0.send_if_modified(|count| {
            let free = *count < MOST;
            *count += usize::from(free);
            free
        });
        entered.then(|| Seat(Arc::clone(&self.0)))
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.0.send_modify(|count| *count -= 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn places_are_bounded_and_become_free() {
        let viewers = Viewers::default();
        let mut seats: Vec<_> = (0..MOST).map(|_| viewers.enter().unwrap()).collect();
        assert!(viewers.enter().is_none());
        seats.pop();
        assert!(viewers.enter().is_some());
        let waiting = viewers.clone();
        let gone = tokio::spawn(async move { waiting.gone(Duration::from_secs(60)).await });
        drop(seats);
        gone.await.unwrap();
        assert_eq!(viewers.count(), 0);
    }
}
