//! Boards that calibrate a camera, and their corners in a photo.

mod charuco;
mod chessboard;
mod edge;
mod grid;
mod layout;
mod marker;
mod partial;
mod print;
mod quad;
mod refine;
mod sighting;
mod text;

pub use sighting::Sighting;

use charuco::Charuco;
use chessboard::Chessboard;
use grid::Grid;
use refine::Gray;

/// A planar board, as it was printed.
#[derive(Debug, Clone)]
pub struct Board {
    kind: Kind,
    /// As it was stated.
    text: String,
}

#[derive(Debug, Clone)]
enum Kind {
    Charuco(Charuco),
    Chessboard(Chessboard),
    Grid(Grid),
}

/// A corner of a board, found in a photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Its number. Of a ChArUco board, OpenCV's: row times (columns - 1) plus column, counted from the corner of marker 0;
    /// of a chessboard likewise; of a grid of markers, four times the marker plus 0 to 3 clockwise from its upper left.
    pub id: u32,
    /// On the board, metres: x along the columns, y along the rows.
    pub board: [f64; 2],
    /// In the photo, pixels; the centre of the upper left pixel is (0.5, 0.5).
    pub pixel: [f64; 2],
}

/// The finders of corners put the centre of the upper left pixel at (0, 0).
const CENTRE: f64 = 0.5;

impl Corner {
    fn new(id: u32, board: [f64; 2], pixel: [f64; 2]) -> Self {
        Self { id, board, pixel: pixel.map(|x| x + CENTRE) }
    }

    /// Where the finders have it.
    fn found(&self) -> [f64; 2] {
        self.pixel.map(|x| x - CENTRE)
    }
}

impl Board {
    /// Reads one of these, lengths in metres:
    /// - `charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY`, squares with markers in the white ones, as OpenCV 4.6 and later
    ///   lays it out; `:legacy` behind it is the pattern of before, whose upper left square is white where the rows are even;
    /// - `chessboard:COLUMNSxROWS:SQUARE`, counted in squares, of which OpenCV's corners are one fewer each way;
    /// - `aruco:COLUMNSxROWS:MARKER:GAP:DICTIONARY`, OpenCV's grid of markers, numbered row by row from 0;
    /// - `apriltag:COLUMNSxROWS:MARKER:GAP:FAMILY`, the same with AprilTags, such as 36h11.
    ///
    /// # Errors
    /// Another form, sizes that are none, lengths that can be no metres, an unknown dictionary, or one with too few
    /// markers; the text says how to mend it.
    pub fn parse(text: &str) -> Result<Self, String> {
        Ok(Self { kind: text::parse(text)?, text: text.to_owned() })
    }

    /// As it was stated.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The kind of board, in words.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match &self.kind {
            Kind::Charuco(_) => "ChArUco board",
            Kind::Chessboard(_) => "chessboard",
            Kind::Grid(_) => "grid of markers",
        }
    }

    /// Whether a half turn of the board looks the same, so that its poses may be off by one: a chessboard whose columns
    /// and rows are both odd, or both even.
    #[must_use]
    pub fn turns_unseen(&self) -> bool {
        matches!(&self.kind, Kind::Chessboard(board) if board.turns_unseen())
    }

    /// The same ChArUco board in the layout of before OpenCV 4.6; absent where it is the same one, or no ChArUco board.
    #[must_use]
    pub fn legacy(&self) -> Option<Self> {
        let Kind::Charuco(board) = &self.kind else { return None };
        Some(Self { kind: Kind::Charuco(board.legacy()?), text: format!("{}:legacy", self.text) })
    }

    /// Corners of the board in a gray image of `width` x `height` pixels, in the order of their numbers; empty where it is
    /// not seen. Of ChArUco boards and grids of markers, parts of it suffice.
    #[must_use]
    pub fn find(&self, width: u32, height: u32, gray: &[u8]) -> Vec<Corner> {
        let gray = Gray { width: width as usize, height: height as usize, data: gray };
        let mut corners = match &self.kind {
            Kind::Charuco(board) => board.find(&gray),
            Kind::Chessboard(board) => board.find(&gray),
            Kind::Grid(board) => board.find(&gray),
        };
        corners.sort_by_key(|corner| corner.id);
        corners
    }

    /// What is seen in a photo that does not show the board as stated.
    #[must_use]
    pub fn sighting(&self, width: u32, height: u32, gray: &[u8]) -> Sighting {
        Sighting::new(self, &Gray { width: width as usize, height: height as usize, data: gray })
    }
}
