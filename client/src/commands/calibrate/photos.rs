//! The photos: the board's corners in each, and what those show that do not show it.

use super::{CalibrateArguments, refuse};
use crate::commands::draft::Place;
use crate::failure::Failure;
use crate::output::tell_error;
use gonio_calibrate::{Corner, Sighting, determines_pose};

/// A photo that shows the board.
pub(super) struct File {
    /// As the capture names it.
    pub(super) relative: String,
    /// As it was named.
    pub(super) at: String,
}

/// The photos that show the board.
pub(super) struct Seen {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) files: Vec<File>,
    /// One list per file.
    pub(super) corners: Vec<Vec<Corner>>,
}

/// Reads the photos, and finds the board. What does not show it is told, and left out.
///
/// # Errors
/// A photo that is missing or of another size; a board that more photos show in another layout than in the stated one.
pub(super) fn read(arguments: &CalibrateArguments, place: &Place) -> Result<Seen, Failure> {
    let board = &arguments.board;
    let mut size = None;
    let mut seen = Seen { width: 0, height: 0, files: Vec::new(), corners: Vec::new() };
    let mut unseen = Vec::<Unseen>::new();
    for path in &arguments.photos {
        let at = path.display().to_string();
        let (relative, _) = place.photo(path)?;
        let gray = image::open(path)
            .map_err(|error| refuse(&at, format!("cannot be read: {error}"), "name a PNG, JPEG or TIFF"))?
            .to_luma8();
        let own = gray.dimensions();
        let first = *size.get_or_insert(own);
        if own != first {
            let problem = format!("is {} x {}, the first photo {} x {}", own.0, own.1, first.0, first.1);
            return Err(refuse(&at, problem, "calibrate photos of one camera, unscaled and unturned"));
        }
        let corners = board.find(own.0, own.1, &gray);
        if determines_pose(&corners) {
            seen.files.push(File { relative, at });
            seen.corners.push(corners);
            continue;
        }
        // A board that one photo does not show is no reason to lose the others.
        let sighting = board.sighting(own.0, own.1, &gray);
        let what = match corners.len() {
            0 => format!("does not show the board{}", shown(&sighting)),
            few => format!("{few} corners do not determine the board's pose"),
        };
        match unseen.iter_mut().find(|(cause, _, _)| *cause == what) {
            Some((_, _, photos)) => photos.push(at),
            None => unseen.push((what, sighting.fits, vec![at])),
        }
    }
    other_board(arguments, &unseen, seen.files.len())?;
    for (what, _, photos) in &unseen {
        tell_error(&format!("warning: {}: {what}; left out", photos.join(", ")));
    }
    if board.turns_unseen() {
        tell_error(&format!(
            "warning: --board {}: looks the same after a half turn, so the poses may be off by one; a board of an odd \
             and an even number of squares does not",
            board.text()
        ));
    }
    if arguments.intrinsics.is_some() && seen.files.is_empty() {
        return Err(Failure::Input(format!("--board: no photo shows {}: name the photos that do", board.text())));
    }
    (seen.width, seen.height) = size.unwrap_or_default();
    Ok(seen)
}

/// Why photos are left out, the board that they would fit, and which they are.
type Unseen = (String, Option<String>, Vec<String>);

/// Refuses a board where more photos show another one than the stated one, which `seen` show.
fn other_board(arguments: &CalibrateArguments, unseen: &[Unseen], seen: usize) -> Result<(), Failure> {
    let count = |fits: &String| -> usize {
        let same = unseen.iter().filter(|(_, other, _)| other.as_ref() == Some(fits));
        same.map(|(_, _, photos)| photos.len()).sum()
    };
    let fitting = unseen.iter().filter_map(|(what, fits, photos)| Some((what, fits.as_ref()?, photos)));
    let Some((what, fits, photos)) = fitting.max_by_key(|(_, fits, _)| count(fits)) else { return Ok(()) };
    if count(fits) <= seen {
        return Ok(());
    }
    let (stated, first, photos) = (arguments.board.text(), &photos[0], count(fits));
    let problem = format!("{photos} photos do not show {stated}: {first} {what}");
    Err(Failure::Input(format!("--board: {problem}: write {fits}")))
}

/// Numbers as a reader counts them, such as `0-4 6`.
fn ranges(numbers: &[u32]) -> String {
    let mut ranges: Vec<[u32; 2]> = Vec::new();
    for &number in numbers {
        match ranges.last_mut() {
            Some([_, last]) if *last + 1 == number => *last = number,
            _ => ranges.push([number; 2]),
        }
    }
    let text = |[first, last]: &[u32; 2]| if first == last { first.to_string() } else { format!("{first}-{last}") };
    ranges.iter().map(text).collect::<Vec<_>>().join(" ")
}

/// What a photo shows instead of the board, to stand behind "does not show the board".
fn shown(sighting: &Sighting) -> String {
    let Sighting { dictionary, markers, size, fits } = sighting;
    if !markers.is_empty() {
        let fits = fits.as_ref().map_or_else(String::new, |fits| format!(", as {fits} has them"));
        return format!(" as stated: it shows the markers {} of {dictionary}{fits}", ranges(markers));
    }
    match size {
        Some((columns, rows)) => format!(" as stated: it shows corners of {columns} x {rows} squares"),
        None => String::new(),
    }
}
