//! A grid of markers: ArUco's or AprilTags, one beside the other with gaps of white.

use super::Corner;
use super::charuco::around;
use super::layout::{Layout, Pattern};
use super::marker::read;
use super::refine::Gray;
use crate::homography::{agreed, map};
use calib_targets_charuco::Dictionary;

/// Corners that are farther from where the others have them, in sides of a marker, are those of a marker misread: a lens
/// bends a board by less.
const OFF: f64 = 0.15;

/// OpenCV's `GridBoard`, numbered row by row from 0.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    pub(super) dictionary: Dictionary,
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// Side of a marker, metres.
    pub(super) marker: f64,
    /// Between two markers, metres.
    pub(super) gap: f64,
}

impl Grid {
    /// A grid.
    ///
    /// # Errors
    /// The dictionary has too few markers.
    pub(super) fn new(columns: u32, rows: u32, marker: f64, gap: f64, dictionary: Dictionary) -> Result<Self, String> {
        let (needed, available) = ((columns * rows) as usize, dictionary.codes().len());
        if available < needed {
            return Err(format!("the board needs {needed} markers, the dictionary has {available}"));
        }
        Ok(Self { dictionary, columns, rows, marker, gap })
    }

    pub(super) fn layout(&self) -> Layout {
        Layout { pattern: Pattern::Grid, columns: self.columns }
    }

    /// The corners of the markers that are seen.
    pub(super) fn find(&self, gray: &Gray<'_>) -> Vec<Corner> {
        let markers = read(gray, &[self.dictionary]).pop().unwrap_or_default();
        let own = markers.iter().filter(|marker| marker.id < self.columns * self.rows);
        let corners: Vec<Corner> = own
            .flat_map(|marker| {
                let upper_left = self.layout().place(marker.id).map(|n| f64::from(n) * (self.marker + self.gap));
                around(marker, upper_left, self.marker)
            })
            .collect();
        let Some((h, _)) = agreed(&corners, 2.0) else { return Vec::new() };
        let off = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let fits = |four: &&[Corner]| {
            let side = off(four[0].pixel, four[1].pixel).max(off(four[1].pixel, four[2].pixel));
            four.iter().all(|corner| off(map(&h, corner.board), corner.pixel) <= (OFF * side).max(2.0))
        };
        corners.chunks(4).filter(fits).flatten().copied().collect()
    }
}
