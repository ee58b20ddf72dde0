//! The subcommands, one file or folder each.

pub mod align;
pub mod calibrate;
pub mod check;
pub mod diagnose;
pub mod dprime;
mod draft;
pub mod estimate;
pub mod evaluate;
pub mod export;
pub mod fit;
pub mod import;
pub mod jobs;
pub mod mask;
pub mod new;
pub mod predict;
pub mod prepare;
pub mod render;
pub mod study;
pub mod sweep;

use crate::arguments::FarmArguments;
use crate::failure::Failure;
use crate::farm::{Farm, OpenCapture};
use crate::input::Input;
use crate::program::words;
use gonio_scene::Capture;

/// Opens the capture on the farm that the arguments name: embedded, or behind a URL.
fn open(arguments: &FarmArguments, input: &Input) -> Result<OpenCapture, Failure> {
    Ok(farm(arguments)?.open_input(input)?)
}

/// The farm that the arguments name, for the command of this process.
fn farm(arguments: &FarmArguments) -> Result<Farm, Failure> {
    farm_for(arguments, words().get(1).map_or("", String::as_str))
}

/// The farm that the arguments name, whose list of jobs calls this client by `what` it does.
///
/// # Errors
/// Threads that cannot be started; a farm that cannot be reached, or refuses.
pub fn farm_for(arguments: &FarmArguments, what: &str) -> Result<Farm, Failure> {
    Ok(match &arguments.farm {
        None => Farm::embedded(arguments.threads)?,
        Some(url) => Farm::connect_by(url, &arguments.access)?.named(what),
    })
}

/// The command that was given, for reports.
fn command() -> String {
    words().iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// A word of the command as a shell reads it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Pixels whose films are held in memory at once: 200 MB of them.
const BATCH_PIXELS: u64 = 1 << 24;

/// `photos` in batches, so that memory does not grow with their number.
fn batches(capture: &Capture, photos: &[usize]) -> Vec<Vec<usize>> {
    let mut batches: Vec<Vec<usize>> = Vec::new();
    let mut pixels = u64::MAX;
    for &photo in photos {
        let size = photo_pixels(capture, photo);
        pixels = pixels.saturating_add(size);
        match batches.last_mut() {
            Some(batch) if pixels <= BATCH_PIXELS => batch.push(photo),
            _ => {
                pixels = size;
                batches.push(vec![photo]);
            }
        }
    }
    batches
}

/// Pixels of the photo with index `photo`.
fn photo_pixels(capture: &Capture, photo: usize) -> u64 {
    capture.photos.get(photo).map_or(0, |photo| {
        let camera = capture.camera_of(photo);
        u64::from(camera.width) * u64::from(camera.height)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::capture::{Camera, Photo};

    #[test]
    fn batches_keep_the_order_and_bound_the_pixels() {
        let camera = Camera { width: 3000, height: 2000, ..Camera::default() };
        let capture = Capture { camera, photos: vec![Photo::default(); 5], ..Capture::default() };
        assert_eq!(batches(&capture, &[4, 0, 1, 2, 3]), [vec![4, 0], vec![1, 2], vec![3]]);
        assert!(batches(&capture, &[]).is_empty());
    }

    #[test]
    fn words_are_quoted_where_a_shell_needs_it() {
        assert_eq!(quoted("--start"), "--start");
        assert_eq!(quoted("a b"), "'a b'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
        assert_eq!(quoted(""), "''");
    }
}
