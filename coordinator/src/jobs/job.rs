//! One evaluation that runs, and whoever listens to it.

use super::LINGER;
use crate::broker::{Active, Failure};
use gonio_proto::convert::request::Requester;
use gonio_proto::{Digest, Key};
use gonio_scene::{Evaluation, Progress};
use std::sync::{Arc, OnceLock};
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::Instant;

/// What an evaluation has come to.
#[derive(Debug)]
pub struct Answer {
    /// Statistics and films, in the order of the request's photos.
    pub evaluation: Evaluation,
    /// How far it was when it ended.
    pub progress: Progress,
}

/// How an evaluation ended.
pub type End = Arc<Result<Answer, Failure>>;

/// One evaluation: run by one task, listened to by any number of streams.
#[derive(Debug)]
pub struct Job {
    /// Absent where it ends with its stream.
    pub key: Option<Key>,
    /// Of the request's bytes: the same key for another request is an error.
    pub request: Digest,
    /// Its number in this coordinator.
    pub evaluation: u64,
    /// Whose it is.
    pub requester: Requester,
    /// Of what.
    pub capture: Digest,
    /// When it was accepted.
    pub since: Instant,
    /// Set once, when its photographs are read and it is split.
    pub active: OnceLock<Arc<Active>>,
    /// Streams that listen. Changed by [`Job::listen`] and by the listeners' end.
    listeners: watch::Sender<usize>,
    /// Set once, by the task that runs it.
    end: watch::Sender<Option<End>>,
    /// Set once, by whoever cancels it: why.
    cancelled: watch::Sender<Option<String>>,
    /// Set once a listener has passed on the whole answer.
    delivered: watch::Sender<bool>,
}

/// A stream that listens; dropped, it does not any more.
#[derive(Debug)]
pub struct Listener(Arc<Job>);

impl Job {
    /// An evaluation that is about to run.
    #[must_use]
    pub fn new(key: Option<Key>, request: Digest, evaluation: u64, requester: Requester, capture: Digest) -> Self {
        Self {
            key,
            request,
            evaluation,
            requester,
            capture,
            since: Instant::now(),
            active: OnceLock::new(),
            listeners: watch::Sender::new(0),
            end: watch::Sender::new(None),
            cancelled: watch::Sender::new(None),
            delivered: watch::Sender::new(false),
        }
    }

    /// Listens, until the listener is dropped.
    #[must_use]
    pub fn listen(self: &Arc<Self>) -> Listener {
        self.listeners.send_modify(|listeners| *listeners += 1);
        Listener(Arc::clone(self))
    }

    /// Streams that listen.
    #[must_use]
    pub fn listeners(&self) -> usize {
        *self.listeners.borrow()
    }

    /// Completes when nobody has listened for a while: at once for an evaluation without a key.
    pub async fn abandoned(&self) {
        let linger = if self.key.is_some() { LINGER } else { Duration::ZERO };
        let mut listeners = self.listeners.subscribe();
        loop {
            // The sender lives as long as `self`.
            let _ = listeners.wait_for(|listeners| *listeners == 0).await;
            let back = listeners.wait_for(|listeners| *listeners > 0);
            if tokio::time::timeout(linger, back).await.is_err() {
                return;
            }
        }
    }

    /// Ends it, as somebody wishes.
    pub fn cancel(&self, why: &str) {
        self.cancelled.send_if_modified(|cancelled| {
            let first = cancelled.is_none();
            cancelled.get_or_insert_with(|| why.to_owned());
            first
        });
    }

    /// Completes when it is cancelled, with the reason.
    pub async fn cancelled(&self) -> String {
        let mut cancelled = self.cancelled.subscribe();
        cancelled.wait_for(Option::is_some).await.ok().and_then(|why| why.clone()).unwrap_or_default()
    }

    /// Tells all who listen, and will, how it ended.
    pub fn finish(&self, end: Result<Answer, Failure>) {
        self.end.send_replace(Some(Arc::new(end)));
    }

    /// Completes when it has ended.
    pub async fn ended(&self) -> Option<End> {
        let mut end = self.end.subscribe();
        end.wait_for(Option::is_some).await.ok().and_then(|end| end.clone())
    }

    /// Notes that its answer has been passed on.
    pub fn deliver(&self) {
        self.delivered.send_replace(true);
    }

    /// Completes when its answer has been passed on.
    pub async fn delivered(&self) {
        let _ = self.delivered.subscribe().wait_for(|delivered| *delivered).await;
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.0.listeners.send_modify(|listeners| *listeners -= 1);
    }
}
