//! `gonio calibrate`: a camera, and where it stood, from photos of a board.

mod intrinsics;
mod outcome;
mod photos;

use super::draft::Place;
use crate::failure::Failure;
use crate::output::tell_error;
use clap::{Args, ValueEnum};
use gonio_calibrate::{Board, Calibration, Refusal, calibrate, locate};
use gonio_scene::SceneError;
use photos::Seen;
use std::path::PathBuf;

/// `gonio calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateArguments {
    /// Photos of the board, all of one size: at least 3, from different directions (with --intrinsics, at least 1)
    #[arg(required = true)]
    pub photos: Vec<PathBuf>,
    /// The board, lengths in metres: charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY, such as charuco:5x7:0.04:0.02:6X6_250,
    /// and :legacy behind it for a board of before OpenCV 4.6; chessboard:COLUMNSxROWS:SQUARE, counted in squares;
    /// aruco:COLUMNSxROWS:MARKER:GAP:DICTIONARY; apriltag:COLUMNSxROWS:MARKER:GAP:36h11
    #[arg(long, value_name = "BOARD", value_parser = Board::parse)]
    pub board: Board,
    /// The capture.toml to write: the camera, and each photo's pose above the board; must not exist yet
    #[arg(long, value_name = "DIR/capture.toml")]
    pub out: PathBuf,
    /// Take the camera of this capture (or the JSON object that --json wrote), and find the poses only
    #[arg(long, value_name = "FILE")]
    pub intrinsics: Option<PathBuf>,
    /// What is not looked for
    #[arg(long, value_name = "WHAT", value_enum, conflicts_with = "intrinsics")]
    pub fix: Vec<Fix>,
    /// Write the result as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What a calibration does not look for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Fix {
    /// The lens does not distort: k1 k2 p1 p2 k3 are 0
    Distortion,
}

/// Finds the board, calibrates, writes and tells.
///
/// # Errors
/// A photo that is missing, or of another size; photos that do not show the board, or do not determine a camera.
pub fn run(arguments: &CalibrateArguments) -> Result<(), Failure> {
    let place = Place::new(&arguments.out)?;
    let Seen { width, height, files, corners } = photos::read(arguments, &place)?;
    let distortion = !arguments.fix.contains(&Fix::Distortion);
    let result = match &arguments.intrinsics {
        Some(file) => locate(&intrinsics::read(file, width, height)?, &corners),
        None => calibrate(width, height, &corners, distortion),
    };
    let result = result.map_err(|refusal| named(&files, &refusal))?;
    warn(&files, &result);
    outcome::write(arguments, &place, &files, &result)
}

/// A refusal with the photo's name.
fn named(files: &[photos::File], refusal: &Refusal) -> Failure {
    match refusal.photo.and_then(|photo| files.get(photo)) {
        Some(file) => Failure::Input(format!("--board: {}: {}", file.at, refusal.problem)),
        None => Failure::Input(format!("--board: {refusal}")),
    }
}

/// Corners and photos that were dropped.
fn warn(files: &[photos::File], result: &Calibration) {
    for (file, photo) in files.iter().zip(&result.photos) {
        let at = &file.at;
        if photo.corners == 0 {
            let error = photo.error;
            tell_error(&format!(
                "warning: {at}: contradicts the others (its corners are off by {error:.2} px); it is left out: another camera \
                 or zoom, or a board that is not flat"
            ));
        } else if !photo.dropped.is_empty() {
            let each: Vec<String> = photo.dropped.iter().map(|(id, off)| format!("{id} by {off:.2} px")).collect();
            tell_error(&format!("warning: {at}: corners that are off are dropped: {}", each.join(", ")));
        }
    }
}

/// An error about a photo's file.
fn refuse(at: &str, problem: impl Into<String>, mend: impl Into<String>) -> Failure {
    SceneError::new(at, problem, mend).into()
}
