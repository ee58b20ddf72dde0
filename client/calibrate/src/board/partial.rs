//! Corners of a chessboard of which only a part is seen: where the markers and the corners that were found have them,
//! if four squares do meet there.

use super::charuco::MOST_REACH;
use super::refine::Gray;
use super::{CENTRE, Corner};
use crate::homography::{agreed, homography, map};
use nalgebra::Matrix3;

/// The squares of a board.
pub(super) struct Squares {
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// Side, metres.
    pub(super) square: f64,
    /// From a square's side to its marker, as a part of the side.
    pub(super) gap: f64,
    /// The upper left square is white.
    pub(super) white: bool,
}

/// Points near a corner from which its place is predicted: enough for noise, few enough for a lens that bends.
const NEAR: usize = 12;
/// How far the nearest of them may be, in squares: the marker beside a corner, or the next corner.
const FAR: f64 = 1.6;
/// How far a corner may be from where it is predicted, in squares, and in pixels where squares are small.
const OFF: (f64, f64) = (0.08, 1.5);
/// Where the four squares are looked at, along their diagonals, in parts of the gap: nothing else reaches there.
const LOOKS: [f64; 2] = [0.45, 0.85];
/// The darkest white and the brightest black must differ by this part of the difference of their means, and the means
/// by so many gray levels.
const APART: (f64, f64) = (0.4, 15.0);

/// The corners `found` and those beside them and beside `markers`, as far as four squares meet in them. Markers that do not
/// lie as the others do count for nothing.
pub(super) fn complete(gray: &Gray<'_>, squares: &Squares, markers: &[Corner], found: Vec<Corner>) -> Vec<Corner> {
    let all = [markers, &found].concat();
    let Some((whole, agrees)) = agreed(&all, 2.0) else { return found };
    // A lens bends the board by less than this.
    let close = 0.25 * size(&whole, squares, [0.5 * f64::from(squares.columns), 0.5 * f64::from(squares.rows)]);
    let known: Vec<Corner> = all
        .iter()
        .zip(agrees)
        .filter(|(corner, agrees)| {
            let [x, y] = map(&whole, corner.board);
            *agrees || (x - corner.pixel[0]).hypot(y - corner.pixel[1]) < close
        })
        .map(|(corner, _)| *corner)
        .collect();
    let per_row = squares.columns - 1;
    let corner = |id: u32| {
        let board = [id % per_row, id / per_row].map(|n| f64::from(n + 1) * squares.square);
        let distance = |other: &Corner| (other.board[0] - board[0]).hypot(other.board[1] - board[1]);
        let mut near = known.clone();
        near.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        near.truncate(NEAR);
        if distance(near.first()?) > FAR * squares.square {
            return None;
        }
        let own = homography(&near).filter(|own| agree(own, &whole, board, close)).unwrap_or(whole);
        let place = [id % per_row + 1, id / per_row + 1].map(f64::from);
        let size = size(&own, squares, place);
        let start = map(&own, board);
        let before = found.iter().find(|corner| corner.id == id);
        let pixel = match before {
            Some(corner) => corner.pixel,
            None => {
                let reach = (squares.gap * size).clamp(2.0, MOST_REACH) as i32;
                gray.refine(start.map(|x| x - CENTRE), reach).map(|x| x + CENTRE)
            }
        };
        let off = (pixel[0] - start[0]).hypot(pixel[1] - start[1]);
        let fits = before.is_some() || off <= (OFF.0 * size).max(OFF.1);
        (fits && meet(gray, squares, &own, place, pixel)).then_some(Corner { id, board, pixel })
    };
    (0..per_row * (squares.rows - 1)).filter_map(corner).collect()
}

fn agree(own: &Matrix3<f64>, whole: &Matrix3<f64>, board: [f64; 2], close: f64) -> bool {
    let ([x, y], [u, v]) = (map(own, board), map(whole, board));
    (x - u).hypot(y - v) < close
}

/// The shorter side of a square about `place` (in squares), pixels.
fn size(h: &Matrix3<f64>, squares: &Squares, place: [f64; 2]) -> f64 {
    let at = |dx: f64, dy: f64| map(h, [(place[0] + dx) * squares.square, (place[1] + dy) * squares.square]);
    let side = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    side(at(-0.5, 0.0), at(0.5, 0.0)).min(side(at(0.0, -0.5), at(0.0, 0.5)))
}

/// Whether two white squares and two black ones meet at `pixel`, as the board has them at `place` (in squares).
fn meet(gray: &Gray<'_>, squares: &Squares, h: &Matrix3<f64>, place: [f64; 2], pixel: [f64; 2]) -> bool {
    let centre = map(h, place.map(|n| n * squares.square));
    let (mut white, mut black) = (Vec::new(), Vec::new());
    for look in LOOKS {
        for (dx, dy) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let aside =
                [(dx, 0), (dy, 1)].map(|(d, k): (f64, usize)| (place[k] + d * look * squares.gap) * squares.square);
            let [x, y] = map(h, aside);
            let value = gray.at(x - centre[0] + pixel[0] - CENTRE, y - centre[1] + pixel[1] - CENTRE);
            // The square up and left of corner (i, j) is (i - 1, j - 1); squares of even sum have the first one's colour.
            let even = (place[0] + place[1]) as i64 % 2 == 0;
            if (even == (dx == dy)) == squares.white { white.push(value) } else { black.push(value) }
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let difference = mean(&white) - mean(&black);
    let apart = white.iter().fold(f64::INFINITY, |a, &b| a.min(b)) - black.iter().fold(0.0, |a: f64, &b| a.max(b));
    difference >= APART.1 && apart >= APART.0 * difference
}
