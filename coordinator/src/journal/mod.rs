//! What a coordinator writes into its store, so that the next one goes on where it stopped.
//!
//! A log of numbered segments, each created once. To own the farm is to have written the last claim: a coordinator that
//! starts reads the log, then creates the next number with a larger epoch; whoever owned the farm finds that number taken
//! when it writes again, and stops. Records are written in groups: while one put is under way, what comes waits for the
//! next, so that a slow store costs delay and not throughput.
//!
//! What is written is small: a request when it is accepted, a tile's sums (or pixels) when all its tasks are committed, and
//! the end. A task whose tile was not complete is rendered again, to the same bits.

mod claim;
mod owner;
mod replay;
mod writer;

pub use claim::{ClaimError, open};
pub use owner::wait_for_silence;
pub use replay::Restored;

use gonio_proto::{Key, wire};
use std::time::Duration;
use tokio::sync::{mpsc, oneshot, watch};
use wire::journal_record::Record;

/// Folder of the log in the store.
const FOLDER: &str = "journal";

/// Largest segment that is read back, bytes; writers stay below a quarter of it plus one record.
const SEGMENT_BYTES: u64 = 1 << 30;

/// How often the owner renews its mark.
pub const MARK: Duration = Duration::from_secs(2);

/// What the writer is told.
#[derive(Debug)]
enum Entry {
    /// A record on its way, and who waits for it to be written.
    Record { record: Box<wire::JournalRecord>, written: Option<oneshot::Sender<()>> },
    /// Nothing comes any more: a standby need not wait. The sender is dropped when that is written.
    Release(oneshot::Sender<()>),
}

/// The journal of the coordinator that owns the farm. Clones write the same one.
#[derive(Debug, Clone)]
pub struct Journal {
    epoch: u64,
    entries: mpsc::Sender<Entry>,
    /// Set once, by the writer: why nothing is written any more.
    lost: watch::Receiver<Option<String>>,
}

impl Journal {
    /// The coordinator's: larger than that of every one before it.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Writes down that an evaluation is accepted; completes once that is in the store. `false`: the farm is lost.
    pub async fn accept(&self, key: Key, request: wire::EvaluationRequest) -> bool {
        let (written, done) = oneshot::channel();
        let entry = Entry::Record { record: record(key, Record::Accepted(request)), written: Some(written) };
        self.entries.send(entry).await.is_ok() && done.await.is_ok()
    }

    /// Writes down that an evaluation is over.
    pub async fn over(&self, key: Key) {
        let entry = Entry::Record { record: record(key, Record::Over(wire::Over {})), written: None };
        // Without a writer the farm is another's, which knows its evaluations itself.
        let _ = self.entries.send(entry).await;
    }

    /// Writes down a reduced tile. Waits while the store is far behind, so call it where blocking is allowed.
    pub fn keep(&self, key: Key, tile: wire::ReducedTile) {
        let _ = self.entries.blocking_send(Entry::Record { record: record(key, Record::Tile(tile)), written: None });
    }

    /// Writes what waits, and that this coordinator has stopped; completes when that is in the store, or cannot be.
    pub async fn release(&self) {
        let (released, done) = oneshot::channel();
        if self.entries.send(Entry::Release(released)).await.is_ok() {
            let _ = done.await;
        }
    }

    /// Whether this coordinator does not own the farm any more.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.lost.borrow().is_some()
    }

    /// Completes when this coordinator does not own the farm any more, with the reason.
    pub async fn lost(&self) -> String {
        let mut lost = self.lost.clone();
        match lost.wait_for(Option::is_some).await {
            Ok(why) => why.clone().unwrap_or_default(),
            Err(_) => "the journal's writer has ended".to_owned(),
        }
    }
}

fn record(key: Key, record: Record) -> Box<wire::JournalRecord> {
    Box::new(wire::JournalRecord { key: key.to_wire(), record: Some(record) })
}
