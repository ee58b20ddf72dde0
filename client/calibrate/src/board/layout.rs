//! Where the markers of a board lie, in squares or markers.

/// How markers are laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pattern {
    /// In the white squares, row by row; the upper left square is black (OpenCV from 4.6 on).
    Black,
    /// The same; the upper left square is white (OpenCV before 4.6, where the rows are even).
    White,
    /// One beside the other, without squares.
    Grid,
}

/// Markers of a board of so many columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) pattern: Pattern,
    pub(super) columns: u32,
}

impl Layout {
    /// Column and row of marker `id`.
    pub(super) fn place(self, id: u32) -> [u32; 2] {
        // Two rows of squares hold as many markers as there are columns.
        let (pair, rest) = (id / self.columns, id % self.columns);
        let first = match self.pattern {
            Pattern::Grid => return [rest, pair],
            Pattern::Black => self.columns / 2,
            Pattern::White => self.columns.div_ceil(2),
        };
        let shift = u32::from(self.pattern == Pattern::Black);
        if rest < first { [2 * rest + shift, 2 * pair] } else { [2 * (rest - first) + 1 - shift, 2 * pair + 1] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_follow_each_other_through_the_white_squares() {
        for (pattern, parity) in [(Pattern::Black, 1), (Pattern::White, 0)] {
            for columns in 2..9 {
                let layout = Layout { pattern, columns };
                let white = (0..6 * columns).map(|k| [k % columns, k / columns]).filter(|[i, j]| (i + j) % 2 == parity);
                for (id, place) in (0..).zip(white) {
                    assert_eq!(layout.place(id), place, "{pattern:?} {columns} {id}");
                }
            }
        }
        assert_eq!(Layout { pattern: Pattern::Grid, columns: 4 }.place(9), [1, 2]);
    }
}
