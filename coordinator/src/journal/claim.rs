//! How a coordinator comes to own a farm.

use super::replay::{Replay, Restored};
use super::writer::Writer;
use super::{FOLDER, Journal, SEGMENT_BYTES};
use bytes::Bytes;
use gonio_proto::{Key, wire};
use gonio_store::{Blobs, StoreError};
use prost::Message;
use tokio::sync::{mpsc, watch};

/// Records that wait for the writer; more wait at their source.
const WAITING: usize = 1024;

/// Why a farm cannot be taken over.
#[derive(Debug, thiserror::Error)]
pub enum ClaimError {
    /// The store fails.
    #[error("--store: the journal cannot be read or written: {0}")]
    Store(#[from] StoreError),
    /// A segment is not what a coordinator writes.
    #[error(
        "--store: segment {number} of the journal is damaged ({problem}); move journal/ away to start without what ran"
    )]
    Damaged {
        /// Which.
        number: u64,
        /// What is wrong with it.
        problem: String,
    },
    /// No random numbers.
    #[error("cannot start: {0}")]
    Random(#[from] std::io::Error),
}

/// Takes over the farm whose journal is in this store, from whoever owns it, and returns what runs there.
///
/// # Errors
/// The store fails, or the journal is damaged.
pub async fn open(blobs: &Blobs) -> Result<(Journal, Vec<Restored>), ClaimError> {
    let log = blobs.log(FOLDER);
    let writer = Key::fresh()?.to_wire();
    loop {
        let numbers = log.numbers().await?;
        let mut replay = Replay::default();
        for number in &numbers {
            // One that is gone meanwhile was deleted by its owner, because all that it tells of is over.
            let Some(bytes) = log.get(*number, SEGMENT_BYTES).await? else { continue };
            let damaged = |problem: String| ClaimError::Damaged { number: *number, problem };
            let segment = wire::JournalSegment::decode(bytes).map_err(|error| damaged(error.to_string()))?;
            replay.add(*number, segment).map_err(|error| damaged(error.to_string()))?;
        }
        let next = numbers.last().map_or(1, |last| last + 1);
        let epoch = replay.epoch + 1;
        let claim = wire::JournalSegment { epoch, writer: writer.clone(), records: vec![] };
        if !log.put_new(next, Bytes::from(claim.encode_to_vec())).await? {
            // The owner wrote meanwhile, or another coordinator starts: read on.
            continue;
        }
        let (entries, receiver) = mpsc::channel(WAITING);
        let (lost, why) = watch::channel(None);
        let (restored, live) = replay.finish(next);
        tracing::info!(epoch, evaluations = restored.len(), "owns the farm");
        tokio::spawn(Writer { log, epoch, writer, next: next + 1, live, lost }.run(receiver));
        return Ok((Journal { epoch, entries, lost: why }, restored));
    }
}
