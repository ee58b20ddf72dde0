//! What runs, as who watches hears it.

use super::event::{progress, progress_to_wire};
use super::request::{Class, Requester};
use super::{Digest, Key, Result, required, text};
use crate::wire;
use gonio_scene::Progress;
use std::time::Duration;

/// One evaluation that runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Absent where it ends with its stream.
    pub key: Option<Key>,
    /// Whose it is.
    pub requester: Requester,
    /// Of what.
    pub capture: Digest,
    /// How far it is.
    pub progress: Progress,
    /// Clients that listen.
    pub listeners: u32,
    /// Since it was accepted.
    pub age: Duration,
}

impl Job {
    /// The message about it.
    #[must_use]
    pub fn to_wire(&self) -> wire::Job {
        wire::Job {
            key: self.key.map(Key::to_wire).unwrap_or_default(),
            client: self.requester.client.clone(),
            class: self.requester.class.to_wire(),
            capture_digest: self.capture.to_wire(),
            progress: Some(progress_to_wire(self.progress)),
            listeners: self.listeners,
            age_milliseconds: u64::try_from(self.age.as_millis()).unwrap_or(u64::MAX),
        }
    }

    /// The evaluation of a message.
    ///
    /// # Errors
    /// What breaks the protocol.
    pub fn from_wire(job: &wire::Job) -> Result<Self> {
        Ok(Self {
            key: Key::from_wire("Job.key", &job.key)?,
            requester: Requester { client: text(&job.client), class: Class::from_wire("Job.class", job.class)? },
            capture: Digest::from_wire("Job.capture_digest", &job.capture_digest)?,
            progress: progress(&required("Job.progress", job.progress)?)?,
            listeners: job.listeners,
            age: Duration::from_millis(job.age_milliseconds),
        })
    }
}
