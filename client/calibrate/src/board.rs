//! The ChArUco board and its corners in a photo.

use crate::refine::Gray;
use calib_targets_charuco::{
    CharucoBoardSpec, CharucoDetector, CharucoParams, Dictionary, GrayImageView, resolve_dictionary,
};
use chess_corners::UpscaleConfig;

/// A planar board of `columns` x `rows` squares with markers in the white ones, as OpenCV 4.6 and later numbers it, or as
/// those before did.
#[derive(Debug, Clone)]
pub struct Board {
    spec: CharucoBoardSpec,
    square: f64,
    /// Rows of squares that `spec` has above the board: one in the layout of before OpenCV 4.6 where the rows are even.
    above: u32,
}

/// A corner between squares, found in a photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// OpenCV's number: row times (columns - 1) plus column, counted from the corner of marker 0.
    pub id: u32,
    /// On the board, metres: x along the columns, y along the rows.
    pub board: [f64; 2],
    /// In the photo, pixels; the centre of the upper left pixel is (0.5, 0.5).
    pub pixel: [f64; 2],
}

const MEND: &str = "write charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY with lengths in metres, such as \
                    charuco:5x7:0.04:0.02:6X6_250, and :legacy behind it for a board of before OpenCV 4.6";

impl Board {
    /// Reads `charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY`, lengths in metres; `:legacy` behind it is OpenCV's pattern of
    /// before 4.6, whose upper left square is white where the rows are even.
    ///
    /// # Errors
    /// Another form, sizes that are none, an unknown dictionary, or one with too few markers; the text says how to mend it.
    pub fn parse(text: &str) -> Result<Self, String> {
        let words: Vec<&str> = text.split(':').collect();
        let (size, square, marker, dictionary, legacy) = match words[..] {
            ["charuco", size, square, marker, dictionary] => (size, square, marker, dictionary, false),
            ["charuco", size, square, marker, dictionary, "legacy"] => (size, square, marker, dictionary, true),
            _ => return Err(MEND.to_owned()),
        };
        let number = |word: &str| word.parse::<u32>().ok().filter(|n| (2..=200).contains(n));
        let length = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0);
        let (columns, rows) = size.split_once('x').ok_or(MEND)?;
        let (Some(columns), Some(rows)) = (number(columns), number(rows)) else {
            return Err(format!("{size} is no number of squares from 2x2 to 200x200: {MEND}"));
        };
        let (Some(square), Some(marker)) = (length(square), length(marker)) else {
            return Err(format!("{square}:{marker} are no lengths: {MEND}"));
        };
        if marker >= square {
            return Err(format!("the marker ({marker} m) must be smaller than the square ({square} m)"));
        }
        let found = resolve_dictionary(dictionary)
            .ok_or_else(|| format!("{dictionary} is no dictionary: name one of OpenCV's, such as 4X4_50 or 6X6_250"))?;
        let spec = CharucoBoardSpec::new(rows, columns, square as f32, (marker / square) as f32, found);
        let board = Self { spec, square, above: 0 };
        // Where the rows are odd, both layouts are the same.
        let board = if legacy && rows % 2 == 0 {
            board
                .legacy()
                .ok_or_else(|| format!("{dictionary} has too few markers to look for a legacy board of {size}"))?
        } else {
            board
        };
        CharucoDetector::new(CharucoParams::for_board(board.spec)).map_err(|error| error.to_string())?;
        Ok(board)
    }

    /// The same board in the layout of before OpenCV 4.6, `None` where it is the same one or the dictionary is too small.
    ///
    /// That layout begins with a white square where the rows are even: it is the present one without its first row. So it is
    /// looked for as a board of one row more, whose first markers are codes that the board does not have.
    #[must_use]
    pub fn legacy(&self) -> Option<Self> {
        if self.above > 0 || self.spec.rows % 2 == 1 {
            return None;
        }
        let (rows, columns) = (self.spec.rows, self.spec.cols);
        // White squares of the row above, and of the board itself.
        let (first, own) = ((columns / 2) as usize, (rows * columns / 2) as usize);
        let codes = self.spec.dictionary.codes();
        let (kept, spare) = (codes.get(..own)?, codes.get(own..own + first)?);
        let name = self.spec.dictionary.name();
        let (bits, correction) = (self.spec.dictionary.marker_size(), self.spec.dictionary.max_correction_bits());
        // The library keeps codes for the whole run; a run parses one board.
        let codes: &'static [u64] = Box::leak([spare, kept].concat().into_boxed_slice());
        let dictionary = Dictionary::from_static_codes(name, bits, correction, codes).ok()?;
        let mut spec = self.spec;
        (spec.rows, spec.dictionary) = (rows + 1, dictionary);
        Some(Self { spec, square: self.square, above: 1 })
    }

    /// Corners of the board in a gray image, row by row, in the order of their numbers; empty where it is not seen.
    ///
    /// Each of a few settings of the detector is tried, and the one that finds most corners taken.
    #[must_use]
    pub fn find(&self, width: u32, height: u32, gray: &[u8]) -> Vec<Corner> {
        let view = GrayImageView { width: width as usize, height: height as usize, data: gray };
        let per_row = self.spec.cols - 1;
        let mut best = Vec::new();
        for (upscale, strength) in FRONT_ENDS {
            let mut params = CharucoParams::for_board(self.spec);
            params.chess.upscale = upscale;
            params.chessboard.min_corner_strength = strength;
            let found = CharucoDetector::new(params).ok().and_then(|detector| detector.detect(&view).ok());
            let corners: Vec<Corner> = found
                .iter()
                .flat_map(|found| &found.corners)
                // The corners of a row that is not there are those of the board's edge.
                .filter_map(|corner| Some((corner.id.checked_sub(self.above * per_row)?, corner)))
                .map(|(id, corner)| Corner {
                    id,
                    board: [id % per_row, id / per_row].map(|n| f64::from(n + 1) * self.square),
                    pixel: [corner.position.x, corner.position.y].map(|x| f64::from(x) + CENTRE),
                })
                .collect();
            if corners.len() > best.len() {
                best = corners;
            }
        }
        self.refine(&Gray { width: width as usize, height: height as usize, data: gray }, &mut best);
        best.sort_by_key(|corner| corner.id);
        best
    }

    /// Sharpens the corners within windows that no marker reaches into, as OpenCV does.
    fn refine(&self, gray: &Gray<'_>, corners: &mut [Corner]) {
        let at = corners.to_vec();
        let gap = 0.5 * f64::from(1.0 - self.spec.marker_size_rel);
        for corner in corners {
            let distance = |other: &Corner| {
                let [x, y] = [0, 1].map(|k| other.pixel[k] - corner.pixel[k]);
                x.hypot(y)
            };
            let square = at.iter().map(distance).filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
            let reach = (gap * square).clamp(2.0, MOST_REACH) as i32;
            let [x, y] = gray.refine(corner.pixel.map(|x| x - CENTRE), reach);
            corner.pixel = [x + CENTRE, y + CENTRE];
        }
    }
}

/// Pixels to either side of a corner that are looked at, where there is room: OpenCV's largest window, too.
const MOST_REACH: f64 = 10.0;

/// The detector puts the centre of the upper left pixel at (0, 0).
const CENTRE: f64 = 0.5;

/// Magnification of the photo, and the weakest corner that is taken. Small photos need the magnification; the threshold
/// keeps corners of the markers, and noise, out of the grid.
const FRONT_ENDS: [(UpscaleConfig, f32); 4] = [
    (UpscaleConfig::Fixed(2), 80.0),
    (UpscaleConfig::Fixed(2), 40.0),
    (UpscaleConfig::Disabled, 80.0),
    (UpscaleConfig::Disabled, 33.0),
];
