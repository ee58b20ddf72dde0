//! The ChArUco board: a chessboard with markers in its white squares.

use super::layout::{Layout, Pattern};
use super::marker::{Marker, read};
use super::partial::{Squares, complete};
use super::refine::Gray;
use super::{CENTRE, Corner};
use calib_targets_charuco::{CharucoBoardSpec, CharucoDetector, CharucoParams, Dictionary, GrayImageView};
use chess_corners::UpscaleConfig;

/// A board of `columns` x `rows` squares, as OpenCV 4.6 and later numbers it, or as those before did.
#[derive(Debug, Clone)]
pub(super) struct Charuco {
    spec: CharucoBoardSpec,
    pub(super) dictionary: Dictionary,
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// Side of a square, metres.
    pub(super) square: f64,
    /// Side of a marker, metres.
    pub(super) marker: f64,
    /// The layout of before OpenCV 4.6: `spec` has a row of squares above the board.
    pub(super) legacy: bool,
}

impl Charuco {
    /// A board in the present layout.
    ///
    /// # Errors
    /// The dictionary has too few markers.
    pub(super) fn new(
        columns: u32,
        rows: u32,
        square: f64,
        marker: f64,
        dictionary: Dictionary,
    ) -> Result<Self, String> {
        let spec = CharucoBoardSpec::new(rows, columns, square as f32, (marker / square) as f32, dictionary);
        CharucoDetector::new(CharucoParams::for_board(spec)).map_err(|error| error.to_string())?;
        Ok(Self { spec, dictionary, columns, rows, square, marker, legacy: false })
    }

    /// The same board in the layout of before OpenCV 4.6, `None` where it is the same one or the dictionary is too small.
    ///
    /// That layout begins with a white square where the rows are even: it is the present one without its first row. So it is
    /// looked for as a board of one row more, whose first markers are codes that the board does not have.
    pub(super) fn legacy(&self) -> Option<Self> {
        if self.legacy || self.rows % 2 == 1 {
            return None;
        }
        let (rows, columns) = (self.rows, self.columns);
        // White squares of the row above, and of the board itself.
        let (first, own) = ((columns / 2) as usize, (rows * columns / 2) as usize);
        let codes = self.dictionary.codes();
        let (kept, spare) = (codes.get(..own)?, codes.get(own..own + first)?);
        let (bits, correction) = (self.dictionary.marker_size(), self.dictionary.max_correction_bits());
        // The library keeps codes for the whole run; a run parses one board.
        let codes: &'static [u64] = Box::leak([spare, kept].concat().into_boxed_slice());
        let dictionary = Dictionary::from_static_codes(self.dictionary.name(), bits, correction, codes).ok()?;
        let mut spec = self.spec;
        (spec.rows, spec.dictionary) = (rows + 1, dictionary);
        Some(Self { spec, legacy: true, ..self.clone() })
    }

    pub(super) fn layout(&self) -> Layout {
        let pattern = if self.legacy { Pattern::White } else { Pattern::Black };
        Layout { pattern, columns: self.columns }
    }

    /// The board's corners in an image.
    ///
    /// Each of a few settings of the detector is tried, and the one that finds most corners taken. Where that are not all
    /// of them, markers that stand alone say where the others are looked for.
    pub(super) fn find(&self, gray: &Gray<'_>) -> Vec<Corner> {
        let all = ((self.columns - 1) * (self.rows - 1)) as usize;
        let mut best = Vec::new();
        for (upscale, strength) in FRONT_ENDS {
            let corners = self.detect(gray, upscale, strength);
            if corners.len() > best.len() {
                best = corners;
            }
            if best.len() == all {
                break;
            }
        }
        self.refine(gray, &mut best);
        if best.len() < all {
            let markers = read(gray, &[self.dictionary]).pop().unwrap_or_default();
            best = complete(gray, &self.squares(), &self.places(&markers), best);
        }
        best
    }

    fn detect(&self, gray: &Gray<'_>, upscale: UpscaleConfig, strength: f32) -> Vec<Corner> {
        let view = GrayImageView { width: gray.width, height: gray.height, data: gray.data };
        let mut params = CharucoParams::for_board(self.spec);
        params.chess.upscale = upscale;
        params.chessboard.min_corner_strength = strength;
        let found = CharucoDetector::new(params).ok().and_then(|detector| detector.detect(&view).ok());
        let per_row = self.columns - 1;
        let above = if self.legacy { per_row } else { 0 };
        let corners = found.iter().flat_map(|found| &found.corners);
        // The corners of a row that is not there are those of the board's edge.
        let own = corners.filter_map(|corner| Some((corner.id.checked_sub(above)?, corner)));
        own.map(|(id, corner)| {
            let board = [id % per_row, id / per_row].map(|n| f64::from(n + 1) * self.square);
            Corner::new(id, board, [corner.position.x, corner.position.y].map(f64::from))
        })
        .collect()
    }

    fn squares(&self) -> Squares {
        let Self { columns, rows, square, marker, legacy, .. } = *self;
        Squares { columns, rows, square, gap: 0.5 * (1.0 - marker / square), white: legacy }
    }

    /// The corners of markers that belong to the board.
    fn places(&self, markers: &[Marker]) -> Vec<Corner> {
        let count = self.columns * self.rows / 2;
        let inset = 0.5 * (self.square - self.marker);
        let own = markers.iter().filter(|marker| marker.id < count);
        own.flat_map(|marker| {
            let upper_left = self.layout().place(marker.id).map(|n| f64::from(n) * self.square + inset);
            around(marker, upper_left, self.marker)
        })
        .collect()
    }

    /// Sharpens the corners within windows that no marker reaches into, as OpenCV does.
    fn refine(&self, gray: &Gray<'_>, corners: &mut [Corner]) {
        let at = corners.to_vec();
        let gap = 0.5 * (1.0 - self.marker / self.square);
        for corner in corners {
            let distance = |other: &Corner| {
                let [x, y] = [0, 1].map(|k| other.pixel[k] - corner.pixel[k]);
                x.hypot(y)
            };
            let square = at.iter().map(distance).filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
            let reach = (gap * square).clamp(2.0, MOST_REACH) as i32;
            corner.pixel = gray.refine(corner.found(), reach).map(|x| x + CENTRE);
        }
    }
}

/// The four corners of a marker of side `side` at `upper_left` on its board, numbered as a grid's.
pub(super) fn around(marker: &Marker, upper_left: [f64; 2], side: f64) -> [Corner; 4] {
    let offsets = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]];
    std::array::from_fn(|k| {
        let board = [0, 1].map(|axis| upper_left[axis] + offsets[k][axis]);
        Corner::new(4 * marker.id + k as u32, board, marker.corners[k])
    })
}

/// Pixels to either side of a corner that are looked at, where there is room: OpenCV's largest window, too.
pub(super) const MOST_REACH: f64 = 10.0;

/// Magnification of the photo, and the weakest corner that is taken. Small photos need the magnification; the threshold
/// keeps corners of the markers, and noise, out of the grid.
pub(super) const FRONT_ENDS: [(UpscaleConfig, f32); 4] = [
    (UpscaleConfig::Fixed(2), 80.0),
    (UpscaleConfig::Fixed(2), 40.0),
    (UpscaleConfig::Disabled, 80.0),
    (UpscaleConfig::Disabled, 33.0),
];
