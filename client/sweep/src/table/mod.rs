//! The table of a sweep: one row for each frame. Its bytes follow from the frames alone, never from who rendered them,
//! when, or in how many runs; what was measured on the way is in a table of its own.

mod csv;
mod parquet;

use crate::digest::FrameDigest;
use crate::plan::Plan;
use crate::record::Record;
use gonio_scene::SceneError;

/// Columns of equal length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    columns: Vec<(String, Column)>,
}

/// The values of a column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Column {
    Whole(Vec<u64>),
    Number(Vec<f64>),
    Text(Vec<String>),
}

impl Table {
    /// The finished sweep: a record for each frame.
    #[must_use]
    pub fn of(plan: &Plan, digests: &[FrameDigest], records: &[&Record]) -> Self {
        let mut table = Self::default();
        let frames = &plan.frames;
        table.whole("frame", (0..frames.len()).map(|i| i as u64));
        table.whole("point", frames.iter().map(|frame| frame.point as u64));
        table.text("view", frames.iter().map(|frame| plan.capture.photos[frame.photo].name().to_owned()));
        for (i, name) in plan.names.iter().enumerate() {
            table.number(name, frames.iter().map(|frame| plan.points[frame.point][i]));
        }
        table.whole("seed", frames.iter().map(|frame| frame.seed));
        table.whole("samples", frames.iter().map(|_| u64::from(plan.samples)));
        table.whole("width", records.iter().map(|record| u64::from(record.width)));
        table.whole("height", records.iter().map(|record| u64::from(record.height)));
        for (channel, name) in ["mean.r", "mean.g", "mean.b"].into_iter().enumerate() {
            table.number(name, records.iter().map(|record| record.mean[channel]));
        }
        table.whole("invalid_samples", records.iter().map(|record| record.invalid_samples));
        table.text("digest", digests.iter().map(ToString::to_string));
        table.text("film_sha256", records.iter().map(|record| record.film_sha256.clone()));
        for output in &plan.outputs {
            table.text(output.word(), digests.iter().map(|digest| digest.path(output.ending())));
        }
        table
    }

    /// What was measured while the frames were rendered.
    #[must_use]
    pub fn timings(digests: &[FrameDigest], records: &[&Record]) -> Self {
        let mut table = Self::default();
        table.whole("frame", (0..digests.len()).map(|i| i as u64));
        table.text("digest", digests.iter().map(ToString::to_string));
        table.number("seconds", records.iter().map(|record| record.seconds));
        table
    }

    /// The table as CSV (RFC 4180 with line feeds), numbers with the digits that read back to the same bits.
    #[must_use]
    pub fn to_csv(&self) -> Vec<u8> {
        csv::write(&self.columns)
    }

    /// The table as Parquet.
    ///
    /// # Errors
    /// None that a table of a sweep could cause; `file` is named in them.
    pub fn to_parquet(&self, file: &str) -> Result<Vec<u8>, SceneError> {
        parquet::write(&self.columns).map_err(|e| SceneError::new(file, e.to_string(), "report this"))
    }

    fn whole(&mut self, name: &str, values: impl Iterator<Item = u64>) {
        self.columns.push((name.to_owned(), Column::Whole(values.collect())));
    }

    fn number(&mut self, name: &str, values: impl Iterator<Item = f64>) {
        self.columns.push((name.to_owned(), Column::Number(values.collect())));
    }

    fn text(&mut self, name: &str, values: impl Iterator<Item = String>) {
        self.columns.push((name.to_owned(), Column::Text(values.collect())));
    }
}
