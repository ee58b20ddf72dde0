//! How a standby knows that the owner lives: a mark that the owner renews, by no clock but the standby's own.

use super::{FOLDER, MARK};
use bytes::Bytes;
use gonio_store::{Blobs, Log, StoreError};
use std::time::Duration;
use tokio::time::Instant;

/// How long a mark may stay the same before its owner is taken for dead: five renewals.
const SILENCE: Duration = MARK.saturating_mul(5);

/// How often a standby looks.
const LOOK: Duration = Duration::from_millis(500);

/// The owner's mark, a line of text: epoch, renewals, and whether the owner has stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Mark {
    pub epoch: u64,
    pub count: u64,
    pub released: bool,
}

impl Mark {
    fn parse(bytes: &[u8]) -> Option<Self> {
        let mut words = std::str::from_utf8(bytes).ok()?.split_whitespace();
        let (epoch, count) = (words.next()?.parse().ok()?, words.next()?.parse().ok()?);
        Some(Self { epoch, count, released: words.next()? == "released" })
    }

    /// Writes the mark, unless a later owner's is there: then its epoch.
    ///
    /// Two owners may write at once, and the former's mark stand for a moment: then the later one writes again, and the
    /// former learns of it here or from its next segment. Who owns the farm is decided by the log alone.
    pub async fn renew(&self, log: &Log) -> Result<Option<u64>, StoreError> {
        let there = log.get_mark().await?.and_then(|bytes| Self::parse(&bytes));
        if let Some(later) = there.filter(|mark| mark.epoch > self.epoch) {
            return Ok(Some(later.epoch));
        }
        let state = if self.released { "released" } else { "lives" };
        log.put_mark(Bytes::from(format!("{} {} {state}\n", self.epoch, self.count))).await?;
        Ok(None)
    }
}

/// Completes when the owner of the farm in this store has stopped, or has not renewed its mark for ten seconds.
pub async fn wait_for_silence(blobs: &Blobs) {
    let log = blobs.log(FOLDER);
    let (mut last, mut since) = (None, Instant::now());
    loop {
        match log.get_mark().await {
            Ok(bytes) => {
                let mark = bytes.and_then(|bytes| Mark::parse(&bytes));
                if mark.is_some_and(|mark| mark.released) {
                    return;
                }
                if mark != last {
                    (last, since) = (mark, Instant::now());
                }
                if since.elapsed() >= SILENCE {
                    return;
                }
            }
            // A store that does not answer says nothing about the owner.
            Err(error) => {
                tracing::warn!(%error, "the owner's mark cannot be read");
                since = Instant::now();
            }
        }
        tokio::time::sleep(LOOK).await;
    }
}
