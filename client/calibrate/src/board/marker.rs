//! Markers of a dictionary, wherever they lie in a photo.

use super::edge::sharpen;
use super::quad::{Quad, quads};
use super::refine::Gray;
use calib_targets_aruco::{MarkerCell, Matcher, ScanDecodeConfig, decode_marker_in_cell};
use calib_targets_charuco::{Dictionary, GrayImageView};
use nalgebra::Point2;

/// The part of the bits that a dictionary can correct which is corrected (OpenCV's default, too).
const CORRECTED: f64 = 0.6;
/// Pixels in which a marker is sampled: it scales what the decoder looks at, not the result.
const SAMPLED: f32 = 96.0;
/// The widest edge that is looked for, pixels, and the part of a marker's cell that it may take.
const WIDEST: f64 = 6.0;
const CELL: f64 = 0.75;
/// The narrowest, pixels: a quadrilateral of pixels is about one off.
const NARROWEST: f64 = 1.5;

/// A marker in a photo.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Marker {
    pub(super) id: u32,
    /// From the marker's own upper left corner, clockwise; pixels, whose centres are whole numbers.
    pub(super) corners: Quad,
}

impl Marker {
    pub(super) fn middle(&self) -> [f64; 2] {
        [0, 1].map(|k| self.corners.iter().map(|corner| corner[k]).sum::<f64>() / 4.0)
    }
}

/// Quadrilaterals that may be markers of `cells` cells a side, with sharp corners.
fn candidates(gray: &Gray<'_>, cells: usize) -> Vec<Quad> {
    let sharp = |quad: Quad| {
        let side = |k: usize| (quad[(k + 1) % 4][0] - quad[k][0]).hypot(quad[(k + 1) % 4][1] - quad[k][1]);
        let shortest = (0..4).map(side).fold(f64::INFINITY, f64::min);
        let reach = (CELL * shortest / cells as f64).clamp(NARROWEST, WIDEST);
        let first = sharpen(gray, &quad, reach)?;
        sharpen(gray, &first, reach.min(0.5 * WIDEST)).or(Some(first))
    };
    quads(gray).into_iter().filter_map(sharp).collect()
}

/// The markers of each of `dictionaries` in a gray image, by their numbers.
pub(super) fn read(gray: &Gray<'_>, dictionaries: &[Dictionary]) -> Vec<Vec<Marker>> {
    let view = GrayImageView { width: gray.width, height: gray.height, data: gray.data };
    let config = ScanDecodeConfig::default().with_inset_frac(0.0);
    let mut quads: std::collections::BTreeMap<usize, Vec<Quad>> = std::collections::BTreeMap::new();
    let mut found = Vec::new();
    for dictionary in dictionaries {
        let cells = dictionary.marker_size() + 2;
        let quads = quads.entry(cells).or_insert_with(|| candidates(gray, cells));
        let matcher = Matcher::new(*dictionary, (CORRECTED * f64::from(dictionary.max_correction_bits())) as u8);
        let mut best = std::collections::BTreeMap::<u32, (f32, Marker)>::new();
        for quad in quads.iter() {
            let corners = quad.map(|[x, y]| Point2::new(x as f32 + 0.5, y as f32 + 0.5));
            let cell = MarkerCell::new(Default::default(), corners);
            let Some(read) = decode_marker_in_cell(&view, &cell, SAMPLED, &config, &matcher) else { continue };
            if read.inverted {
                continue;
            }
            let mut corners = *quad;
            corners.rotate_left(usize::from(read.rotation));
            if best.get(&read.id).is_none_or(|(score, _)| read.score > *score) {
                best.insert(read.id, (read.score, Marker { id: read.id, corners }));
            }
        }
        found.push(best.into_values().map(|(_, marker)| marker).collect());
    }
    found
}
