//! Responses of an image to orientations: spread, looked up and laid out so that a template's score at every place is a
//! sum of whole rows of bytes (Hinterstoisser et al. 2012, section 3).

use crate::gradient::{BINS, Gradients};
use crate::picture::Picture;

/// Places are this many pixels apart, and a feature may be as far from where the template has it.
pub(crate) const STEP: usize = 4;

/// Cells around the image in which a part of a template may lie.
const MARGIN: usize = 8;

/// What a feature adds where the image's nearest orientation is so many bins from its own.
const LOOKED_UP: [u8; 5] = [4, 3, 1, 0, 0];

/// The largest response of one feature.
pub(crate) const MOST: f64 = LOOKED_UP[0] as f64;

/// An image's responses.
pub(crate) struct Responses {
    /// Places along columns and rows.
    pub columns: usize,
    pub rows: usize,
    /// Cells of a row, margins included.
    pitch: usize,
    /// For each orientation and each offset inside a cell, the response of every cell.
    planes: Vec<Vec<u8>>,
}

impl Responses {
    pub fn of(picture: &Picture) -> Self {
        let gradients = Gradients::of(&picture.pixels);
        let (width, height) = (gradients.width, gradients.vectors.len() / gradients.width.max(1));
        let spread = spread(&gradients.bits(), width, height);
        let (columns, rows) = (width.div_ceil(STEP), height.div_ceil(STEP));
        let pitch = columns + 2 * MARGIN;
        let cells = pitch * (rows + 2 * MARGIN);
        let mut planes = vec![vec![0; cells]; BINS * STEP * STEP];
        for bin in 0..BINS {
            let table = table(bin);
            for row in 0..height {
                for column in 0..width {
                    let response = table[spread[row * width + column] as usize];
                    let plane = (bin * STEP + row % STEP) * STEP + column % STEP;
                    planes[plane][(row / STEP + MARGIN) * pitch + column / STEP + MARGIN] = response;
                }
            }
        }
        Self { columns, rows, pitch, planes }
    }

    /// The sums of the responses of a template's features with its centre at each place, into `sums`: the cell of row and
    /// column is at [`Self::cell`].
    pub fn score(&self, features: &[(i32, i32, usize)], sums: &mut Vec<u8>) {
        let length = self.rows * self.pitch;
        sums.clear();
        sums.resize(length, 0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)] // small
        for &(x, y, bin) in features {
            let step = STEP as i32;
            let (inside_x, inside_y) = (x.rem_euclid(step) as usize, y.rem_euclid(step) as usize);
            let plane = &self.planes[(bin * STEP + inside_y) * STEP + inside_x];
            let margin = MARGIN as i32;
            let first = (y.div_euclid(step) + margin) * self.pitch as i32 + x.div_euclid(step) + margin;
            // A feature farther out than the margin is nowhere.
            let Some(values) = usize::try_from(first).ok().and_then(|first| plane.get(first..first + length)) else {
                continue;
            };
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += value;
            }
        }
    }

    /// Where the sum of a place is.
    pub fn cell(&self, column: usize, row: usize) -> usize {
        row * self.pitch + column
    }
}

/// Every pixel takes the orientations of those around it.
fn spread(bits: &[u8], width: usize, height: usize) -> Vec<u8> {
    let reach = STEP / 2;
    let along = |bits: &[u8], length: usize, others: usize, stride: usize, across: usize| {
        let mut out = vec![0; bits.len()];
        for other in 0..others {
            for i in 0..length {
                let window = i.saturating_sub(reach)..(i + reach).min(length);
                out[other * across + i * stride] =
                    window.map(|j| bits[other * across + j * stride]).fold(0, std::ops::BitOr::bitor);
            }
        }
        out
    };
    let rows = along(bits, width, height, 1, width);
    along(&rows, height, width, width, 1)
}

/// The response of one orientation to every set of orientations.
fn table(bin: usize) -> [u8; 256] {
    std::array::from_fn(|set| {
        let apart = |other: usize| {
            let straight = bin.abs_diff(other);
            straight.min(BINS - straight)
        };
        (0..BINS).filter(|other| set & (1 << other) != 0).map(|other| LOOKED_UP[apart(other)]).max().unwrap_or(0)
    })
}
