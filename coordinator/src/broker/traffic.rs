//! Bytes that came and went, what protocols add to them left out.

use std::sync::atomic::{AtomicU64, Ordering};

/// A number of bytes that only grows.
#[derive(Debug, Default)]
pub struct Bytes(AtomicU64);

impl Bytes {
    /// Adds so many.
    pub fn add(&self, bytes: usize) {
        self.0.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    /// How many so far.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// What a coordinator received and sent.
#[derive(Debug, Default)]
pub struct Traffic {
    /// Films from workers, those of results that were refused too.
    pub films: Bytes,
    /// Captures' files from clients.
    pub uploads: Bytes,
    /// Captures' files to workers and clients.
    pub downloads: Bytes,
    /// Progress and results to clients. Those of the same process are sent no bytes.
    pub answers: Bytes,
}
