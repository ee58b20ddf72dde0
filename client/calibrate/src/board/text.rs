//! How a board is stated.

use super::Kind;
use super::charuco::Charuco;
use super::chessboard::Chessboard;
use super::grid::Grid;
use calib_targets_charuco::{Dictionary, resolve_dictionary};

const CHARUCO: &str = "write charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY with lengths in metres, such as \
                       charuco:5x7:0.04:0.02:6X6_250, and :legacy behind it for a board of before OpenCV 4.6";
const CHESSBOARD: &str = "write chessboard:COLUMNSxROWS:SQUARE, counted in squares, with its length in metres, such as \
                          chessboard:10x7:0.025";
const GRID: &str = "write aruco:COLUMNSxROWS:MARKER:GAP:DICTIONARY with lengths in metres, such as \
                    aruco:4x5:0.0375:0.005:6X6_1000, or apriltag: with a family such as 36h11";

/// A length above this is no board's, metres: it was given in millimetres or centimetres.
const LONGEST: f64 = 1.0;

/// The words of a board, and how it is written.
struct Words<'a> {
    all: Vec<&'a str>,
    form: &'static str,
}

impl Words<'_> {
    fn size(&self) -> Result<(u32, u32), String> {
        let form = self.form;
        let text = self.all[1];
        let number = |word: &str| word.parse::<u32>().ok().filter(|n| (2..=200).contains(n));
        let (columns, rows) = text.split_once('x').ok_or(form)?;
        match (number(columns), number(rows)) {
            (Some(columns), Some(rows)) => Ok((columns, rows)),
            _ => Err(format!("{text} is no number of squares or markers from 2x2 to 200x200: {form}")),
        }
    }

    /// The lengths, of which there are `count`.
    fn lengths(&self, count: usize) -> Result<Vec<f64>, String> {
        let words = &self.all[2..2 + count];
        let length = |word: &&str| word.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0);
        let lengths: Vec<f64> = words.iter().filter_map(length).collect();
        if lengths.len() < count {
            return Err(format!("{} are no lengths: {}", words.join(":"), self.form));
        }
        if lengths.iter().any(|length| *length > LONGEST) {
            let metres = |length: &f64| format!("{}", length / 1000.0);
            let mut all = self.all.clone();
            let small: Vec<String> = lengths.iter().map(metres).collect();
            all.splice(2..2 + count, small.iter().map(String::as_str));
            let (given, all) = (words.join(" and "), all.join(":"));
            return Err(format!(
                "{given} would be metres: lengths are in metres; if these are millimetres, write {all}"
            ));
        }
        Ok(lengths)
    }
}

fn dictionary(name: &str) -> Result<Dictionary, String> {
    resolve_dictionary(name).ok_or_else(|| {
        format!("{name} is no dictionary: name one of OpenCV's, such as 4X4_50, 6X6_250 or APRILTAG_36h11")
    })
}

pub(super) fn parse(text: &str) -> Result<Kind, String> {
    let all: Vec<&str> = text.split(':').collect();
    let form = match all[0] {
        "chessboard" => CHESSBOARD,
        "aruco" | "apriltag" => GRID,
        _ => CHARUCO,
    };
    let words = Words { all, form };
    match words.all[..] {
        ["charuco", _, _, _, name] | ["charuco", _, _, _, name, "legacy"] => {
            let ((columns, rows), lengths) = (words.size()?, words.lengths(2)?);
            let (square, marker) = (lengths[0], lengths[1]);
            if marker >= square {
                return Err(format!("the marker ({marker} m) must be smaller than the square ({square} m)"));
            }
            let board = Charuco::new(columns, rows, square, marker, dictionary(name)?)?;
            // Where the rows are odd, both layouts are the same.
            if words.all.len() == 5 || rows % 2 == 1 {
                return Ok(Kind::Charuco(board));
            }
            let few = || format!("{name} has too few markers to look for a legacy board of {columns}x{rows}");
            Ok(Kind::Charuco(board.legacy().ok_or_else(few)?))
        }
        ["chessboard", _, _] => {
            let ((columns, rows), lengths) = (words.size()?, words.lengths(1)?);
            if columns.min(rows) < 3 {
                return Err(format!("{columns}x{rows} squares have one row of corners: {form}"));
            }
            Ok(Kind::Chessboard(Chessboard::new(columns, rows, lengths[0])))
        }
        [kind @ ("aruco" | "apriltag"), _, _, _, name] => {
            let ((columns, rows), lengths) = (words.size()?, words.lengths(2)?);
            let prefixed = format!("APRILTAG_{name}");
            let name = if kind == "apriltag" && resolve_dictionary(name).is_none() { &prefixed } else { name };
            Ok(Kind::Grid(Grid::new(columns, rows, lengths[0], lengths[1], dictionary(name)?)?))
        }
        _ => Err(form.to_owned()),
    }
}
