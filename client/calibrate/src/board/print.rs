//! A board as geometry: what of it is white and what is black.

use super::charuco::Charuco;
use super::grid::Grid;
use super::{Board, Kind};
use calib_targets_charuco::Dictionary;
use gonio_scene::mesh::Mesh;

/// A rectangle of the board: left, upper, right and lower side, metres; y counts down the rows.
type Rectangle = [f64; 4];

/// What is printed.
#[derive(Debug, Default)]
struct Print {
    white: Vec<Rectangle>,
    black: Vec<Rectangle>,
}

impl Board {
    /// The board as two meshes in its own plane, white parts first: x along the columns, y up (against the rows), z towards who
    /// looks at it, metres; the origin is the upper left corner. Paper beyond the board is in neither.
    #[must_use]
    pub fn meshes(&self) -> [Mesh; 2] {
        let mut print = Print::default();
        match &self.kind {
            Kind::Chessboard(board) => {
                for k in 0..board.columns * board.rows {
                    let (i, j) = (k % board.columns, k / board.columns);
                    let at = [i, j].map(|n| f64::from(n) * board.square);
                    print.add((i + j) % 2 == 0, at, [board.square; 2]);
                }
            }
            Kind::Charuco(board) => print.charuco(board),
            Kind::Grid(board) => print.grid(board),
        }
        [mesh(&print.white), mesh(&print.black)]
    }
}

impl Print {
    fn add(&mut self, black: bool, [x, y]: [f64; 2], [width, height]: [f64; 2]) {
        let of = if black { &mut self.black } else { &mut self.white };
        of.push([x, y, x + width, y + height]);
    }

    fn charuco(&mut self, board: &Charuco) {
        // Both layouts are a chessboard's; the markers are in the white squares, by their numbers.
        let parity = u32::from(board.legacy);
        for k in 0..board.columns * board.rows {
            let (i, j) = (k % board.columns, k / board.columns);
            if (i + j + parity) % 2 == 0 {
                self.add(true, [i, j].map(|n| f64::from(n) * board.square), [board.square; 2]);
            }
        }
        let (square, side) = (board.square, board.marker);
        let inset = 0.5 * (square - side);
        for id in 0..board.columns * board.rows / 2 {
            let [x, y] = board.layout().place(id).map(|n| f64::from(n) * square);
            self.add(false, [x, y], [square, inset]);
            self.add(false, [x, y + inset + side], [square, inset]);
            self.add(false, [x, y + inset], [inset, side]);
            self.add(false, [x + inset + side, y + inset], [inset, side]);
            self.marker(&board.dictionary, id, [x + inset, y + inset], side);
        }
    }

    fn grid(&mut self, board: &Grid) {
        let step = board.marker + board.gap;
        for id in 0..board.columns * board.rows {
            let [column, row] = board.layout().place(id);
            let [x, y] = [column, row].map(|n| f64::from(n) * step);
            self.marker(&board.dictionary, id, [x, y], board.marker);
            // The gaps between markers are paper.
            if column + 1 < board.columns {
                self.add(false, [x + board.marker, y], [board.gap, board.marker]);
            }
            if row + 1 < board.rows {
                let last = column + 1 == board.columns;
                self.add(false, [x, y + board.marker], [if last { board.marker } else { step }, board.gap]);
            }
        }
    }

    /// A marker with its black border, one cell wide. Codes hold a 1 for black, row by row from the lowest bit.
    fn marker(&mut self, dictionary: &Dictionary, id: u32, [x, y]: [f64; 2], side: f64) {
        let bits = dictionary.marker_size();
        let code = dictionary.codes().get(id as usize).copied().unwrap_or_default();
        let cells = bits + 2;
        let black = |i: usize, j: usize| {
            let inside = (1..=bits).contains(&i) && (1..=bits).contains(&j);
            !inside || code >> ((j - 1) * bits + i - 1) & 1 == 1
        };
        let at = |n: usize| side * n as f64 / cells as f64;
        for j in 0..cells {
            // Cells of one colour beside each other are one rectangle.
            let mut start = 0;
            for i in 1..=cells {
                if i == cells || black(i, j) != black(start, j) {
                    self.add(black(start, j), [x + at(start), y + at(j)], [at(i) - at(start), at(j + 1) - at(j)]);
                    start = i;
                }
            }
        }
    }
}

/// Two triangles for each rectangle, seen from above.
#[allow(clippy::cast_possible_truncation)] // Meshes are single precision, with few vertices.
fn mesh(rectangles: &[Rectangle]) -> Mesh {
    let corners = |&[left, upper, right, lower]: &Rectangle| {
        [[left, lower], [right, lower], [right, upper], [left, upper]].map(|[x, y]| [x as f32, -y as f32, 0.0])
    };
    let quad = |k: usize| {
        let first = 4 * k as u32;
        [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    };
    Mesh {
        positions: rectangles.iter().flat_map(corners).collect(),
        normals: None,
        triangles: (0..rectangles.len()).flat_map(quad).collect(),
        degenerate: 0,
    }
}
