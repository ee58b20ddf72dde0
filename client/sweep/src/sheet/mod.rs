//! The contact sheet: all frames in small, side by side, equally bright.

mod page;
pub(crate) mod thumbnail;

use crate::digest::FrameDigest;
use crate::plan::Plan;
use crate::record::Record;
use gonio_scene::Result;
use gonio_scene::capture::srgb;
use gonio_scene::image::encode_png8;
use thumbnail::Thumbnail;

/// Most pixels of a sheet.
const MOST_PIXELS: u64 = 12_000_000;

/// Pixels between two frames.
const GAP: u32 = 2;

/// The colour between frames.
const PAPER: [u8; 3] = [32, 32, 32];

/// Places of frames on a picture.
#[derive(Debug, Clone)]
pub struct Sheet<'p> {
    plan: &'p Plan,
    /// Indices of the frames shown: all, or evenly spaced ones where they are too many.
    shown: Vec<usize>,
    columns: u32,
    /// Of the largest thumbnail.
    cell: (u32, u32),
}

impl<'p> Sheet<'p> {
    /// The sheet of a plan.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    pub fn of(plan: &'p Plan) -> Self {
        let mut cell = (1, 1);
        for frame in &plan.frames {
            let camera = plan.capture.camera_of(&plan.capture.photos[frame.photo]);
            let (width, height) = Thumbnail::size(camera.width, camera.height);
            cell = (cell.0.max(width), cell.1.max(height));
        }
        let (area, frames) = (u64::from(cell.0 + GAP) * u64::from(cell.1 + GAP), plan.frames.len() as u64);
        let count = frames.min(MOST_PIXELS / area).max(1);
        let shown: Vec<usize> = (0..count).map(|i| (i * frames / count) as usize).collect();
        let ratio = f64::from(cell.1 + GAP) / f64::from(cell.0 + GAP);
        // A third wider than high.
        let columns = ((count as f64 * ratio * 4.0 / 3.0).sqrt().ceil() as u32).clamp(1, count as u32);
        Self { plan, shown, columns, cell }
    }

    /// The frames shown, in order; the thumbnails of others need not be kept.
    #[must_use]
    pub fn frames(&self) -> &[usize] {
        &self.shown
    }

    fn place(&self, i: usize) -> (u32, u32) {
        let (column, row) = (i as u32 % self.columns, i as u32 / self.columns);
        (GAP + column * (self.cell.0 + GAP), GAP + row * (self.cell.1 + GAP))
    }

    fn size(&self) -> (u32, u32) {
        let rows = (self.shown.len() as u32).div_ceil(self.columns);
        (GAP + self.columns * (self.cell.0 + GAP), GAP + rows * (self.cell.1 + GAP))
    }

    /// The picture as PNG. White is what all but a hundredth of all values are below.
    ///
    /// # Errors
    /// None for the records of a sweep; `file` is named in them.
    pub fn picture(&self, file: &str, records: &[&Record]) -> Result<Vec<u8>> {
        self.picture_of(file, |frame| records.get(frame).copied())
    }

    /// The picture as [`Sheet::picture`], of those frames that have a record yet.
    ///
    /// # Errors
    /// As [`Sheet::picture`].
    pub fn picture_of<'r>(&self, file: &str, record: impl Fn(usize) -> Option<&'r Record>) -> Result<Vec<u8>> {
        let (width, height) = self.size();
        let mut pixels = vec![PAPER; width as usize * height as usize];
        let white = self.white(&record);
        for (i, &frame) in self.shown.iter().enumerate() {
            let Some(record) = record(frame) else { continue };
            let (left, top) = self.place(i);
            let small = &record.thumbnail;
            for (k, value) in small.values().into_iter().enumerate() {
                let (x, y) = (k as u32 % small.width.max(1), k as u32 / small.width.max(1));
                if let Some(pixel) = pixels.get_mut(((top + y) * width + left + x) as usize) {
                    *pixel = value.map(|v| show(v, white, small.is_linear()));
                }
            }
        }
        encode_png8(file, width, height, &pixels)
    }

    /// The page that shows the picture `picture` with what each frame is and where its files are.
    #[must_use]
    pub fn page(&self, title: &str, picture: &str, digests: &[FrameDigest], records: &[&Record]) -> String {
        page::write(self, title, picture, digests, records)
    }

    fn white<'r>(&self, record: impl Fn(usize) -> Option<&'r Record>) -> f64 {
        let shown = self.shown.iter().filter_map(|&frame| record(frame));
        let linear = shown.filter(|record| record.thumbnail.is_linear());
        let mut values: Vec<f64> = linear.flat_map(|record| record.thumbnail.values()).flatten().collect();
        if values.is_empty() {
            return 1.0;
        }
        let place = (values.len() - 1) * 99 / 100;
        let white = *values.select_nth_unstable_by(place, f64::total_cmp).1;
        if white > 0.0 && white.is_finite() { white } else { 1.0 }
    }
}

/// A photo value as a byte of the screen.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn show(value: f64, white: f64, linear: bool) -> u8 {
    let encoded = if linear { srgb((value / white).clamp(0.0, 1.0)).0 } else { value };
    (255.0 * encoded).round().clamp(0.0, 255.0) as u8
}
