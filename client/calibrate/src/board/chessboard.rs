//! The plain chessboard. It must be seen as a whole: nothing on it says which part a part is.

use super::charuco::{FRONT_ENDS, MOST_REACH};
use super::refine::Gray;
use super::{CENTRE, Corner};
use calib_targets_charuco::GrayImageView;
use calib_targets_chessboard::{ChessboardDetector, ChessboardParams, default_chess_config, detect_corners};
use chess_corners::UpscaleConfig;
use std::collections::BTreeMap;

/// The part of a square, about a corner, that is looked at.
const REACH: f64 = 0.4;

/// A chessboard of `columns` x `rows` squares, the upper left one black.
#[derive(Debug, Clone)]
pub(super) struct Chessboard {
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// Side of a square, metres.
    pub(super) square: f64,
}

/// Corners by their column and row on some grid, from (0, 0) on; pixel centres are whole numbers.
type Lattice = BTreeMap<(i32, i32), [f64; 2]>;

impl Chessboard {
    pub(super) fn new(columns: u32, rows: u32, square: f64) -> Self {
        Self { columns, rows, square }
    }

    pub(super) fn turns_unseen(&self) -> bool {
        (self.columns + self.rows).is_multiple_of(2)
    }

    /// The largest grid of corners in an image.
    fn lattice(gray: &Gray<'_>, upscale: UpscaleConfig, strength: f32) -> Lattice {
        let view = GrayImageView { width: gray.width, height: gray.height, data: gray.data };
        let (mut config, mut params) = (default_chess_config(), ChessboardParams::default());
        (config.upscale, params.min_corner_strength) = (upscale, strength);
        let Ok(detector) = ChessboardDetector::new(params) else { return Lattice::new() };
        let found = detector.detect(&detect_corners(&view, &config));
        let corners = found.iter().flat_map(|found| &found.corners);
        corners
            .map(|corner| ((corner.grid.u, corner.grid.v), [corner.position.x, corner.position.y].map(f64::from)))
            .collect()
    }

    /// Columns and rows of the squares whose corners are seen in an image, one more each way than of corners; the longer
    /// first, `None` where no grid is seen.
    pub(super) fn seen(gray: &Gray<'_>) -> Option<(u32, u32)> {
        let sizes = FRONT_ENDS.iter().filter_map(|&(upscale, strength)| {
            let (width, height) = extent(&Self::lattice(gray, upscale, strength))?;
            Some((width.max(height) as u32 + 1, width.min(height) as u32 + 1))
        });
        sizes.max_by_key(|(width, height)| width * height)
    }

    /// The board's corners in an image; none where it is not seen as a whole (single corners may be missing).
    pub(super) fn find(&self, gray: &Gray<'_>) -> Vec<Corner> {
        let mut best = Vec::new();
        for (upscale, strength) in FRONT_ENDS {
            let corners = self.place(gray, &Self::lattice(gray, upscale, strength));
            if corners.len() > best.len() {
                best = corners;
            }
            if best.len() as u32 == (self.columns - 1) * (self.rows - 1) {
                break;
            }
        }
        best
    }

    fn place(&self, gray: &Gray<'_>, lattice: &Lattice) -> Vec<Corner> {
        let Some((width, height)) = extent(lattice) else { return Vec::new() };
        let (right, down) = (width - 1, height - 1);
        // The turns of the grid; a board is never seen from behind.
        let turns: [(bool, Turn); 4] = [
            (false, Box::new(|u, v| (u, v))),
            (false, Box::new(move |u, v| (right - u, down - v))),
            (true, Box::new(move |u, v| (v, right - u))),
            (true, Box::new(move |u, v| (down - v, u))),
        ];
        let (columns, rows) = (self.columns as i32 - 1, self.rows as i32 - 1);
        let fitting = turns
            .into_iter()
            .filter(|(across, _)| (width, height) == if *across { (rows, columns) } else { (columns, rows) });
        let turned =
            fitting.map(|(_, turn)| -> Lattice { lattice.iter().map(|(&(u, v), at)| (turn(u, v), *at)).collect() });
        let mut turned: Vec<Lattice> = turned.filter(|lattice| starts_black(gray, lattice)).collect();
        // Where several turns look alike, the first corner is the one that is nearest to the photo's upper left.
        turned.sort_by(|a, b| first(a).total_cmp(&first(b)));
        let Some(lattice) = turned.first() else { return Vec::new() };
        let corner = |(&(u, v), &at): (&(i32, i32), &[f64; 2])| {
            let distance = |(du, dv): (i32, i32)| {
                lattice.get(&(u + du, v + dv)).map(|other| (other[0] - at[0]).hypot(other[1] - at[1]))
            };
            let near = [(1, 0), (-1, 0), (0, 1), (0, -1)].into_iter().filter_map(distance);
            let reach = (REACH * near.fold(f64::INFINITY, f64::min)).clamp(2.0, MOST_REACH) as i32;
            let board = [u, v].map(|n| f64::from(n + 1) * self.square);
            Corner { id: (v * columns + u) as u32, board, pixel: gray.refine(at, reach).map(|x| x + CENTRE) }
        };
        lattice.iter().map(corner).collect()
    }
}

type Turn = Box<dyn Fn(i32, i32) -> (i32, i32)>;

/// Columns and rows of corners.
fn extent(lattice: &Lattice) -> Option<(i32, i32)> {
    let most = |axis: fn(&(i32, i32)) -> i32| lattice.keys().map(axis).max();
    Some((most(|at| at.0)? + 1, most(|at| at.1)? + 1))
}

/// How far down and right the first corner is, pixels.
fn first(lattice: &Lattice) -> f64 {
    lattice.first_key_value().map_or(f64::INFINITY, |(_, at)| at[0] + at[1])
}

/// Whether the squares between corners are dark where their column and row are both even, or both odd: then so is the
/// board's first square, beside corner (0, 0).
fn starts_black(gray: &Gray<'_>, lattice: &Lattice) -> bool {
    let (mut even, mut odd) = ((0.0, 0.0), (0.0, 0.0));
    for (&(u, v), at) in lattice {
        let others = [(1, 0), (0, 1), (1, 1)].map(|(du, dv)| lattice.get(&(u + du, v + dv)));
        let [Some(a), Some(b), Some(c)] = others else { continue };
        let middle = [0, 1].map(|k| 0.25 * (at[k] + a[k] + b[k] + c[k]));
        let sums = if (u + v) % 2 == 0 { &mut even } else { &mut odd };
        *sums = (sums.0 + gray.at(middle[0], middle[1]), sums.1 + 1.0);
    }
    even.0 / even.1 < odd.0 / odd.1
}
