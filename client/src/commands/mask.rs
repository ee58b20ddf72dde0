//! `gonio mask`: masks of photos from where the capture's objects are seen in them.

use super::{batches, farm, photo_pixels};
use crate::arguments::FarmArguments;
use crate::failure::Failure;
use crate::input::Input;
use crate::interrupt::Interrupt;
use crate::output::{Output as Folder, tell, to_json};
use crate::progress::{Console, plural};
use clap::Args;
use gonio_fit::Evaluate;
use gonio_scene::capture::{CAPTURE_FILE, Object};
use gonio_scene::film::FIRST_HIT_CHANNELS;
use gonio_scene::image::encode_png8;
use gonio_scene::{Capture, EvaluationRequest, Film, Output, SceneError, Stream};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// `gonio mask`.
#[derive(Debug, Args)]
pub struct MaskArguments {
    /// The capture's folder or its capture.toml; the photographs' files need not exist
    pub capture: PathBuf,
    /// Folder to write <photo name>.png to, white where the objects are seen; created if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Names of the objects that are white, such as part,knob; of a capture with one object it may be left out
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub objects: Vec<String>,
    /// Pixels by which the white part is larger all round; below 0 smaller, so that what is seen at its edge does not count
    #[arg(long, value_name = "PIXELS", default_value_t = 0, allow_hyphen_values = true,
          value_parser = clap::value_parser!(i32).range(-256..=256))]
    pub grow: i32,
    /// Names of the photos, such as 00,03; all of them where absent
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub photos: Vec<String>,
    /// Where to render.
    #[command(flatten)]
    pub farm: FarmArguments,
}

/// Which pixels are white.
struct Mask {
    width: usize,
    height: usize,
    white: Vec<bool>,
}

/// Renders first hits and writes.
///
/// # Errors
/// A broken capture, a name that is none, a farm that fails, a folder that cannot be written to, Ctrl-C.
pub fn run(arguments: &MaskArguments) -> Result<(), Failure> {
    let interrupt = Interrupt::listen(if arguments.farm.json { "" } else { "stopping; again to kill" })?;
    let input = Input::open(&arguments.capture)?;
    let capture = &input.capture;
    let photos = super::render::selection(capture, &arguments.photos)?;
    let objects = objects(capture, &arguments.objects)?;
    let names: Vec<String> = photos.iter().map(|&photo| format!("{}.png", capture.photos[photo].name())).collect();
    let folder = Folder::create(&arguments.out, &names, &input.root, capture)?;
    let mut console = Console::new(arguments.farm.json);
    let mut open = farm(&arguments.farm)?.open_input(&input)?;
    let total: u64 = photos.iter().map(|&photo| 2 * photo_pixels(capture, photo)).sum();
    let (mut done, mut written, mut empty) = (0, Vec::new(), Vec::new());
    console.begin("rendering");
    for batch in batches(capture, &photos) {
        let request = EvaluationRequest {
            photos: batch,
            samples: 2,
            seed: Stream::Render.seed(0),
            output: Output::FirstHit,
            ..EvaluationRequest::default()
        };
        let seen = open.evaluate(&request, &mut |progress| {
            console.advance(done + progress.primary_samples, total, progress);
            interrupt.flow()
        })?;
        done += seen.primary_samples;
        for film in &seen.films {
            let mask = Mask::of(film, &objects)?.grown(arguments.grow);
            let name = capture.photos[film.photo].name().to_owned();
            let share = mask.share();
            if share == 0.0 {
                empty.push(name.clone());
            }
            let pixels: Vec<[u8; 3]> = mask.white.iter().map(|white| [if *white { 255 } else { 0 }; 3]).collect();
            let file = format!("{name}.png");
            folder.write(&file, &encode_png8(&file, film.width, film.height, &pixels)?)?;
            console.line(&format!("{file}  {:.1} % white", 100.0 * share));
            written.push(
                serde_json::json!({ "photo": name, "file": folder.path(&file).display().to_string(), "share": share }),
            );
        }
    }
    console.end();
    for name in &empty {
        console.warn(&format!("{name}: no object is seen, the mask is black: is the part's place right?"));
    }
    let what = plural(written.len(), "mask");
    if arguments.farm.json {
        tell(&to_json(&serde_json::json!({ "capture": capture.name, "masks": written }))?);
    } else {
        tell(&format!("wrote {what} to {}: `mask = \"...\"` of a [[photo]] names one", folder.dir().display()));
    }
    Ok(())
}

/// Indices of the objects with the given names.
fn objects(capture: &Capture, names: &[String]) -> Result<BTreeSet<usize>, SceneError> {
    let all: Vec<&str> = capture.objects.iter().map(|object| object.name.as_str()).collect();
    let refuse =
        |problem: String| SceneError::new("--objects", problem, format!("the objects are: {}", all.join(", ")));
    match (names, all.len()) {
        (_, 0) => {
            let mend = "add one: `gonio new --meshes` does";
            return Err(SceneError::new(CAPTURE_FILE, "has no [[object]]", mend));
        }
        ([], 1) => return Ok(BTreeSet::from([0])),
        ([], _) => return Err(refuse("is needed: the capture has several objects".to_owned())),
        _ => {}
    }
    let index = |name: &String| {
        let found = capture.objects.iter().position(|object: &Object| object.name == *name);
        found.ok_or_else(|| refuse(format!("names {name:?}, which is no object")))
    };
    names.iter().map(index).collect()
}

impl Mask {
    /// Of a film of first hits.
    fn of(film: &Film, objects: &BTreeSet<usize>) -> Result<Self, Failure> {
        let channel = FIRST_HIT_CHANNELS.iter().position(|name| *name == "object");
        let hits = channel.and_then(|channel| film.channels.get(channel));
        let hits = hits.ok_or_else(|| Failure::Failed("the farm sent no first hits".to_owned()))?;
        // Where a pixel's samples differ the nearest index counts; -1 is nothing.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let white = hits.iter().map(|hit| *hit >= 0.0 && objects.contains(&(hit.round() as usize))).collect();
        Ok(Self { width: film.width as usize, height: film.height as usize, white })
    }

    /// The share of white pixels.
    #[allow(clippy::cast_precision_loss)] // Below 2^52 pixels.
    fn share(&self) -> f64 {
        self.white.iter().filter(|white| **white).count() as f64 / self.white.len().max(1) as f64
    }

    /// Larger by a disk of this radius, or smaller.
    fn grown(self, pixels: i32) -> Self {
        match pixels {
            0 => self,
            1.. => self.dilated(pixels.unsigned_abs() as usize),
            // What is outside grows; outside of the picture nothing is known, so its edge stays.
            _ => self.inverted().dilated(pixels.unsigned_abs() as usize).inverted(),
        }
    }

    fn inverted(mut self) -> Self {
        self.white.iter_mut().for_each(|white| *white = !*white);
        self
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)] // At most 256.
    fn dilated(self, radius: usize) -> Self {
        let Self { width, height, white } = self;
        let mut grown = vec![false; white.len()];
        for row in 0..height {
            // How many white pixels are left of each.
            let mut before = vec![0_usize; width + 1];
            for x in 0..width {
                before[x + 1] = before[x] + usize::from(white[row * width + x]);
            }
            if before[width] == 0 {
                continue;
            }
            for target in row.saturating_sub(radius)..(row + radius + 1).min(height) {
                let down = target.abs_diff(row);
                let reach = ((radius * radius - down * down) as f64).sqrt() as usize;
                for x in 0..width {
                    let (left, right) = (x.saturating_sub(reach), (x + reach + 1).min(width));
                    grown[target * width + x] |= before[right] > before[left];
                }
            }
        }
        Self { width, height, white: grown }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot() -> Mask {
        let white = (0..9 * 7).map(|k| k == 3 * 9 + 4).collect();
        Mask { width: 9, height: 7, white }
    }

    #[test]
    fn a_dot_grows_to_a_disk_and_shrinks_back() {
        // 1 + 4 within 1, 13 within 2: the lattice points of a circle (Gauss).
        for (radius, count) in [(0, 1), (1, 5), (2, 13), (3, 29)] {
            let grown = dot().grown(radius);
            assert_eq!(grown.white.iter().filter(|white| **white).count(), count, "{radius}");
            assert_eq!(grown.grown(-radius).white, dot().white, "{radius}");
        }
        let whole = Mask { white: vec![true; 63], ..dot() };
        assert!((whole.grown(-2).share() - 1.0).abs() < 1e-12, "the picture's edge is no edge of the part");
    }
}
