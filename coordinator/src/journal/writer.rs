//! The one task that writes a journal.

use super::owner::Mark;
use super::replay::Live;
use super::{Entry, MARK};
use bytes::Bytes;
use gonio_proto::{Key, wire};
use gonio_store::Log;
use prost::Message;
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, oneshot, watch};
use wire::journal_record::Record;

/// What one segment gathers, bytes, before it is written without waiting for more.
const GROUP_BYTES: usize = 8 << 20;

/// How long records that nobody waits for gather before they are written: a lost one costs a tile rendered again, and a file
/// for each would cost a local disk more than the farm's own work does.
const COMPANY: Duration = Duration::from_millis(100);

/// How long a store that fails is asked again. An owner that cannot write cannot promise anything, and a standby is faster.
const PATIENCE: Duration = Duration::from_secs(60);

/// The pause between two such tries.
const PAUSE: Duration = Duration::from_millis(250);

pub(super) struct Writer {
    pub log: Log,
    pub epoch: u64,
    pub writer: Bytes,
    /// Number of the next segment.
    pub next: u64,
    pub live: Live,
    pub lost: watch::Sender<Option<String>>,
}

impl Writer {
    /// Writes until every [`super::Journal`] is dropped or the farm is another's.
    pub async fn run(mut self, mut entries: mpsc::Receiver<Entry>) {
        let mut mark = Mark { epoch: self.epoch, count: 0, released: false };
        let mut ticks = tokio::time::interval(MARK);
        ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut group = Group::default();
        let why = loop {
            tokio::select! {
                // First, so that a busy journal does not look like a dead one.
                biased;
                _ = ticks.tick() => {
                    mark.count += 1;
                    match mark.renew(&self.log).await {
                        Ok(None) => continue,
                        Ok(Some(epoch)) => break taken_by(epoch),
                        // The next write tells whether it lasts; a mark that is late is at worst taken over.
                        Err(error) => {
                            tracing::warn!(%error, "the owner's mark was not renewed");
                            continue;
                        }
                    }
                }
                () = group.gather(&mut entries) => {}
            }
            let group = std::mem::take(&mut group);
            if !group.records.is_empty()
                && let Err(why) = self.write(group.records, group.written).await
            {
                break why;
            }
            if group.last {
                mark.released = true;
                if let Err(error) = mark.renew(&self.log).await {
                    tracing::warn!(%error, "the owner's mark was not released");
                }
                drop(group.released);
                return;
            }
        };
        tracing::error!(why, "the farm is lost");
        self.lost.send_replace(Some(why));
    }

    async fn write(
        &mut self,
        records: Vec<wire::JournalRecord>,
        written: Vec<oneshot::Sender<()>>,
    ) -> Result<(), String> {
        let segment = wire::JournalSegment { epoch: self.epoch, writer: self.writer.clone(), records };
        let bytes = Bytes::from(segment.encode_to_vec());
        if !self.put(bytes).await? {
            return Err(taken_by(self.epoch + 1));
        }
        for written in written {
            let _ = written.send(());
        }
        self.forget(&segment).await
    }

    /// Writes the next segment, and asks a store that fails again. `false`: another coordinator's is there.
    async fn put(&self, bytes: Bytes) -> Result<bool, String> {
        let begin = Instant::now();
        loop {
            match self.log.put_new(self.next, bytes.clone()).await {
                Ok(written) => return Ok(written),
                Err(error) if begin.elapsed() < PATIENCE => tracing::warn!(%error, "the journal is written again"),
                Err(error) => return Err(format!("the journal cannot be written: {error}")),
            }
            tokio::time::sleep(PAUSE).await;
        }
    }

    /// Notes what the segment tells of, and deletes the oldest ones that tell of nothing which runs.
    async fn forget(&mut self, segment: &wire::JournalSegment) -> Result<(), String> {
        let mut live = std::collections::BTreeSet::new();
        for record in &segment.records {
            let Ok(Some(key)) = Key::from_wire("key", &record.key) else { continue };
            if matches!(record.record, Some(Record::Over(_))) {
                live.remove(&key);
                for keys in self.live.values_mut() {
                    keys.remove(&key);
                }
            } else {
                live.insert(key);
            }
        }
        self.live.insert(self.next, live);
        self.next += 1;
        // In their order: what says that an evaluation is over must not go before what says that it began. The last one
        // stays, for its number.
        while self.live.len() > 1
            && let Some(oldest) = self.live.first_entry()
            && oldest.get().is_empty()
        {
            let number = oldest.remove_entry().0;
            if let Err(error) = self.log.delete(number).await {
                // The next owner reads it once more and deletes it.
                tracing::warn!(number, %error, "a segment that is over was not deleted");
            }
        }
        Ok(())
    }
}

fn taken_by(epoch: u64) -> String {
    format!("another coordinator, of epoch {epoch} or later, owns the farm")
}

/// What is written at once.
#[derive(Default)]
struct Group {
    records: Vec<wire::JournalRecord>,
    bytes: usize,
    /// When the first record came.
    since: Option<tokio::time::Instant>,
    /// Who waits for it.
    written: Vec<oneshot::Sender<()>>,
    /// Whether nothing comes after it.
    last: bool,
    /// Who waits for the farm to be released; dropped when it is.
    released: Option<oneshot::Sender<()>>,
}

impl Group {
    /// Takes what comes until it is to be written: at once where somebody waits, else after [`COMPANY`]. May be dropped at any
    /// await: what has come is here.
    async fn gather(&mut self, entries: &mut mpsc::Receiver<Entry>) {
        while !self.last && self.bytes < GROUP_BYTES {
            let next = match entries.try_recv() {
                Ok(entry) => Some(entry),
                Err(mpsc::error::TryRecvError::Disconnected) => None,
                Err(mpsc::error::TryRecvError::Empty) if !self.written.is_empty() => return,
                Err(mpsc::error::TryRecvError::Empty) => match self.since {
                    None => entries.recv().await,
                    Some(since) => match tokio::time::timeout_at(since + COMPANY, entries.recv()).await {
                        Ok(next) => next,
                        Err(_) => return,
                    },
                },
            };
            match next {
                Some(Entry::Record { record, written }) => {
                    self.bytes += record.encoded_len();
                    self.since.get_or_insert_with(tokio::time::Instant::now);
                    self.records.push(*record);
                    self.written.extend(written);
                }
                Some(Entry::Release(released)) => (self.last, self.released) = (true, Some(released)),
                None => self.last = true,
            }
        }
    }
}
