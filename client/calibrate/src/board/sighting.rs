//! What a photo shows that does not show the board as it was stated: which markers, and the layout that they fit.

use super::chessboard::Chessboard;
use super::layout::{Layout, Pattern};
use super::marker::{Marker, read};
use super::refine::Gray;
use super::{Board, Corner, Kind};
use crate::homography::{agreed, map};
use calib_targets_aruco::builtins::{BUILTIN_DICTIONARY_NAMES, builtin_dictionary};
use calib_targets_charuco::Dictionary;

/// Fewer markers than this fit nearly any layout, and may be read from anything.
const FEWEST: usize = 4;
/// The part of the markers that a layout must explain.
const EXPLAINED: f64 = 0.8;
/// How far a marker may be from where the layout has it, in sides of a marker.
const OFF: f64 = 0.35;
/// The widest board that is tried, in squares or markers.
const WIDEST: u32 = 40;

/// What a photo shows instead of the board.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// The markers' dictionary, by OpenCV's name without `DICT_`; empty where none is seen.
    pub dictionary: String,
    /// Their numbers.
    pub markers: Vec<u32>,
    /// The size of the board, `COLUMNSxROWS` in squares (of a grid, in markers) that they would fit or that is seen; absent
    /// where none is told, or it is as stated.
    pub size: Option<(u32, u32)>,
    /// The board that they would fit, as [`Board::parse`] reads it; absent where none is told, or it is the stated one. Lengths
    /// are those stated, rows as many as are needed at least.
    pub fits: Option<String>,
}

impl Sighting {
    pub(super) fn new(board: &Board, gray: &Gray<'_>) -> Self {
        let (stated, layout, rows) = match &board.kind {
            Kind::Charuco(charuco) => (charuco.dictionary, charuco.layout(), charuco.rows),
            Kind::Grid(grid) => (grid.dictionary, grid.layout(), grid.rows),
            Kind::Chessboard(chessboard) => return Self::squares(board, chessboard, gray),
        };
        let own = read(gray, &[stated]).pop().unwrap_or_default();
        // A few markers of a small dictionary are read from anything.
        let other = if own.len() < FEWEST { others(gray, stated) } else { None };
        let (dictionary, markers) = other.unwrap_or((stated, own));
        let found = fitting(&markers, layout, rows);
        let size = found.map(|(layout, rows)| (layout.columns, rows));
        let same = dictionary.name() == stated.name();
        let fits = match found {
            Some(found) => Some(text(board, found, &dictionary)),
            None if !same && markers.len() >= FEWEST => Some(text(board, (layout, rows), &dictionary)),
            None => None,
        };
        let name = if markers.is_empty() { "" } else { dictionary.name() };
        Self {
            dictionary: name.trim_start_matches("DICT_").to_owned(),
            markers: markers.iter().map(|marker| marker.id).collect(),
            size,
            fits: fits.filter(|text| *text != board.text),
        }
    }

    fn squares(board: &Board, stated: &Chessboard, gray: &Gray<'_>) -> Self {
        let seen = Chessboard::seen(gray);
        let (long, short) = (stated.columns.max(stated.rows), stated.columns.min(stated.rows));
        let size = seen.filter(|seen| *seen != (long, short));
        // A part of the board is no other board.
        let larger = size.filter(|(a, b)| *a > long || *b > short || (a + 1, b + 1) == (long, short));
        let fits = larger.map(|(a, b)| {
            let length = board.text.rsplit(':').next().unwrap_or_default();
            format!("chessboard:{a}x{b}:{length}")
        });
        Self { dictionary: String::new(), markers: Vec::new(), size, fits }
    }
}

/// The dictionary of which most markers are seen, the smallest such one.
fn others(gray: &Gray<'_>, stated: Dictionary) -> Option<(Dictionary, Vec<Marker>)> {
    let mut all: Vec<Dictionary> =
        BUILTIN_DICTIONARY_NAMES.iter().filter_map(|name| builtin_dictionary(name)).collect();
    all.retain(|dictionary| dictionary.name() != stated.name());
    all.sort_by_key(|dictionary| std::cmp::Reverse(dictionary.codes().len()));
    let read = read(gray, &all);
    let best = all.into_iter().zip(read).max_by_key(|(_, markers)| markers.len())?;
    (best.1.len() >= FEWEST).then_some(best)
}

/// The layout other than `stated` in which most markers lie, and how many rows that needs; `None` where they lie as stated.
fn fitting(markers: &[Marker], stated: Layout, rows: u32) -> Option<(Layout, u32)> {
    if markers.len() < FEWEST {
        return None;
    }
    let enough = (EXPLAINED * markers.len() as f64).ceil() as usize;
    let needed = |layout: Layout| markers.iter().map(|marker| layout.place(marker.id)[1] + 1).max().unwrap_or(2).max(2);
    let patterns = [stated.pattern, Pattern::Black, Pattern::White, Pattern::Grid];
    let columns = [stated.columns].into_iter().chain(2..=WIDEST);
    let all = columns.flat_map(|columns| patterns.map(|pattern| Layout { pattern, columns }));
    let mut best: Option<(usize, Layout)> = None;
    for layout in all {
        let explained = explained(markers, layout);
        if explained >= enough && best.is_none_or(|(most, _)| explained > most) {
            best = Some((explained, layout));
        }
    }
    let (_, layout) = best?;
    let least = needed(layout);
    if layout == stated && least <= rows {
        return None;
    }
    // A white first square tells the old layout from the new one only where the rows are even.
    let rows = if layout.columns == stated.columns { rows.max(least) } else { least };
    let rows = if layout.pattern == Pattern::White { rows.next_multiple_of(2) } else { rows };
    Some((layout, rows))
}

/// How many markers lie where `layout` has them.
fn explained(markers: &[Marker], layout: Layout) -> usize {
    let middle = |marker: &Marker| {
        let board = layout.place(marker.id).map(f64::from);
        Corner::new(marker.id, board, marker.middle())
    };
    let corners: Vec<Corner> = markers.iter().map(middle).collect();
    let Some((h, _)) = agreed(&corners, 2.0) else { return 0 };
    let fits = |(marker, corner): &(&Marker, &Corner)| {
        let side = |k: usize| {
            let (a, b) = (marker.corners[k], marker.corners[(k + 1) % 4]);
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        let at = map(&h, corner.board);
        let off = (at[0] - corner.pixel[0]).hypot(at[1] - corner.pixel[1]);
        // The marker is neither mirrored nor turned against its neighbours: its columns go along the board's.
        let [next, own] = [1.0, 0.0].map(|d| map(&h, [corner.board[0] + d, corner.board[1]]));
        let along = [marker.corners[1][0] - marker.corners[0][0], marker.corners[1][1] - marker.corners[0][1]];
        let cosine = (next[0] - own[0]) * along[0] + (next[1] - own[1]) * along[1];
        off <= OFF * side(0).min(side(1)) && cosine > 0.7 * (next[0] - own[0]).hypot(next[1] - own[1]) * side(0)
    };
    markers.iter().zip(&corners).filter(fits).count()
}

/// The board that was found, in the form of the stated one as far as it has its lengths.
fn text(board: &Board, (layout, rows): (Layout, u32), dictionary: &Dictionary) -> String {
    let name = dictionary.name().trim_start_matches("DICT_");
    let columns = layout.columns;
    let words: Vec<&str> = board.text.split(':').collect();
    match (layout.pattern, &board.kind) {
        (Pattern::Grid, Kind::Grid(_)) => format!("aruco:{columns}x{rows}:{}:{}:{name}", words[2], words[3]),
        (Pattern::Grid, _) => format!("aruco:{columns}x{rows}:MARKER:GAP:{name}"),
        (pattern, kind) => {
            let lengths = match kind {
                Kind::Charuco(_) => format!("{}:{}", words[2], words[3]),
                _ => "SQUARE:MARKER".to_owned(),
            };
            let legacy = if pattern == Pattern::White { ":legacy" } else { "" };
            format!("charuco:{columns}x{rows}:{lengths}:{name}{legacy}")
        }
    }
}
