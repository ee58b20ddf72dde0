//! A sweep's progress and its contact sheet so far on the page.

use super::Watch;
use gonio_sweep::{FrameDigest, Record, Sheet};
use serde_json::{Map, json};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Least time between two sheets, and how many times as long as one takes to draw.
const SHEET: (Duration, u32) = (Duration::from_secs(2), 10);

/// When a sweep's sheet was drawn last.
pub struct SheetWatch<'w> {
    watch: &'w Watch,
    /// Frames shown when it was drawn, and from when on it may be drawn again.
    drawn: (usize, Instant),
}

impl<'w> SheetWatch<'w> {
    /// Nothing is drawn yet.
    pub fn new(watch: &'w Watch) -> Self {
        Self { watch, drawn: (0, Instant::now()) }
    }

    /// Draws the sheet of the frames that are there, if somebody looks, there are new ones, and the last is not recent;
    /// `last`, in any case.
    pub fn draw(
        &mut self,
        sheet: &Sheet<'_>,
        digests: &[FrameDigest],
        records: &BTreeMap<FrameDigest, Record>,
        last: bool,
    ) {
        let Some(board) = self.watch.board().filter(|_| self.watch.is_watched()) else { return };
        let begin = Instant::now();
        if !last && (records.len() == self.drawn.0 || begin < self.drawn.1) {
            return;
        }
        let of = |frame: usize| digests.get(frame).and_then(|digest| records.get(digest));
        if let Ok(png) = sheet.picture_of("sheet.png", of) {
            let frames = digests.iter().filter(|digest| records.contains_key(digest)).count();
            let mut said = Map::new();
            said.insert("frames".to_owned(), json!(frames));
            said.insert("of".to_owned(), json!(digests.len()));
            board.picture("sheet", png.into(), said);
        }
        self.drawn = (records.len(), Instant::now() + SHEET.0.max(SHEET.1 * begin.elapsed()));
    }
}

impl Watch {
    /// Shows how far a sweep is: frames rendered of those to render, camera samples a second, seconds left.
    pub fn frames(&self, rendered: usize, frames: usize, rate: f64, left: Option<f64>) {
        if let Some(board) = self.board() {
            let label = "Frames";
            board.set(
                "progress",
                json!({ "label": label, "done": rendered, "total": frames, "unit": "frame", "rate": rate, "left": left }),
            );
        }
    }
}
