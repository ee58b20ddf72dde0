//! From a journal's segments to what runs.

use gonio_proto::convert::reduced::Reduced;
use gonio_proto::{Key, WireError, wire};
use std::collections::{BTreeMap, BTreeSet};
use wire::journal_record::Record;

/// An evaluation that was accepted and is not over.
#[derive(Debug)]
pub struct Restored {
    /// Its name.
    pub key: Key,
    /// What was asked for.
    pub request: wire::EvaluationRequest,
    /// Tiles that are reduced, by index.
    pub tiles: BTreeMap<u64, Reduced>,
}

/// Evaluations that a segment tells of and that are not over, by the segment's number: the oldest segments that tell of none
/// can be deleted.
pub(super) type Live = BTreeMap<u64, BTreeSet<Key>>;

/// Reads segments in their order.
#[derive(Debug, Default)]
pub(super) struct Replay {
    /// The largest so far.
    pub epoch: u64,
    running: BTreeMap<Key, Restored>,
    live: Live,
}

impl Replay {
    /// Reads the next segment.
    ///
    /// # Errors
    /// What no coordinator writes.
    pub fn add(&mut self, number: u64, segment: wire::JournalSegment) -> Result<(), WireError> {
        self.epoch = self.epoch.max(segment.epoch);
        let mut live = BTreeSet::new();
        for record in segment.records {
            let key = Key::from_wire("JournalRecord.key", &record.key)?;
            let key = key.ok_or_else(|| WireError::new("JournalRecord.key", "is absent"))?;
            match record.record {
                Some(Record::Accepted(request)) => {
                    self.running.insert(key, Restored { key, request, tiles: BTreeMap::new() });
                    live.insert(key);
                }
                Some(Record::Tile(tile)) => {
                    // Sums that overflowed, for one: their evaluation will say so again.
                    let tile = Reduced::from_wire(tile);
                    if let (Some(running), Ok((index, reduced))) = (self.running.get_mut(&key), tile) {
                        running.tiles.insert(index, reduced);
                        live.insert(key);
                    }
                }
                Some(Record::Over(_)) => {
                    self.running.remove(&key);
                    live.remove(&key);
                    self.live.values_mut().for_each(|keys| {
                        keys.remove(&key);
                    });
                }
                None => return Err(WireError::new("JournalRecord.record", "is absent or unknown here")),
            }
        }
        self.live.insert(number, live);
        Ok(())
    }

    /// What runs, and which segments tell of it; `claim` is the number of the new owner's claim.
    pub fn finish(mut self, claim: u64) -> (Vec<Restored>, Live) {
        self.live.insert(claim, BTreeSet::new());
        (self.running.into_values().collect(), self.live)
    }
}
