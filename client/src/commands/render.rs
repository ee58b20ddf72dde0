//! `gonio render`: films, and first-hit buffers, as OpenEXR.

use super::{batches, farm, photo_pixels};
use crate::arguments::{RenderArguments, RenderOptions};
use crate::failure::Failure;
use crate::farm::Farm;
use crate::input::Input;
use crate::interrupt::Interrupt;
use crate::output::{Output as Folder, tell, to_json};
use crate::progress::{Console, count, metric, plural};
use gonio_fit::Evaluate;
use gonio_scene::capture::Photo;
use gonio_scene::film::FIRST_HIT_CHANNELS;
use gonio_scene::image::encode_exr_channels;
use gonio_scene::{Capture, Evaluation, EvaluationRequest, Film, Output, SceneError, SensorStage, Stream};
use serde::Serialize;
use std::collections::BTreeSet;
use std::time::Instant;

/// What `--json` writes.
#[derive(Serialize)]
struct Rendered {
    capture: String,
    samples: u32,
    seed: u64,
    seconds: f64,
    primary_samples: u64,
    /// Samples that were NaN or infinite and count as black.
    invalid_samples: u64,
    photos: Vec<RenderedPhoto>,
}

/// One photo's files.
#[derive(Serialize)]
struct RenderedPhoto {
    name: String,
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    buffers: Option<String>,
    width: u32,
    height: u32,
    /// Mean photo value per channel.
    mean: [f64; 3],
}

/// A photo as a capture says that it should look.
#[derive(Debug)]
pub struct Frame {
    /// Index of the photo in the capture.
    pub photo: usize,
    /// Photo values: three channels of 32-bit floats, the top row first.
    pub image: Film,
    /// First hits, with the channels of [`FIRST_HIT_CHANNELS`], where they were asked for.
    pub buffers: Option<Film>,
}

/// What frames took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Traced {
    /// Camera samples.
    pub primary_samples: u64,
    /// Samples that were NaN or infinite and count as black.
    pub invalid_samples: u64,
}

/// Renders photos of a capture on `farm`, in the capture's order, and gives each to `seen`.
///
/// # Errors
/// A name that is no photo, a capture that is broken, a farm that fails, an interruption, what `seen` fails with.
pub fn frames(
    input: &Input,
    farm: &Farm,
    options: &RenderOptions,
    console: &mut Console,
    interrupt: &Interrupt,
    seen: &mut dyn FnMut(Frame, &Console) -> Result<(), Failure>,
) -> Result<Traced, Failure> {
    let capture = &input.capture;
    let photos = selection(capture, &options.photos)?;
    let mut open = farm.open_input(input)?;
    let samples = u64::from(options.samples);
    let total: u64 = photos.iter().map(|&photo| photo_pixels(capture, photo).saturating_mul(samples)).sum();
    console.begin("rendering");
    let mut traced = Traced::default();
    for batch in batches(capture, &photos) {
        let mut evaluate = |output: Output, done: u64| -> Result<Evaluation, Failure> {
            let request = EvaluationRequest {
                photos: batch.clone(),
                samples: if output == Output::FirstHit { 2 } else { options.samples },
                seed: Stream::Render.seed(options.seed),
                output,
                ..EvaluationRequest::default()
            };
            Ok(open.evaluate(&request, &mut |progress| {
                let mut overall = *progress;
                if output == Output::FirstHit {
                    overall.primary_samples = 0;
                }
                overall.primary_samples += done;
                console.advance(overall.primary_samples, total, &overall);
                interrupt.flow()
            })?)
        };
        let lit = evaluate(Output::Films, traced.primary_samples)?;
        traced.primary_samples += lit.primary_samples;
        traced.invalid_samples += lit.invalid_samples;
        let hits = if options.buffers { evaluate(Output::FirstHit, traced.primary_samples)?.films } else { Vec::new() };
        let mut hits = hits.into_iter();
        for film in &lit.films {
            let image = SensorStage::of(capture, film.photo).photo_values(film);
            seen(Frame { photo: film.photo, image, buffers: hits.next() }, console)?;
        }
    }
    console.end();
    if traced.invalid_samples > 0 {
        let samples = plural(usize::try_from(traced.invalid_samples).unwrap_or(usize::MAX), "sample");
        console.warn(&format!("{samples} were NaN or infinite and count as black"));
    }
    Ok(traced)
}

/// Renders and writes.
///
/// # Errors
/// A broken capture, a farm that fails, a folder that cannot be written to, Ctrl-C.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    let begin = Instant::now();
    let interrupt = Interrupt::listen(if arguments.farm.json { "" } else { "stopping; again to kill" })?;
    let input = Input::open(&arguments.capture)?;
    let photos = selection(&input.capture, &arguments.options.photos)?;
    let folder = Folder::create(&arguments.out, &file_names(&input.capture, &photos)?, &input.root, &input.capture)?;
    let mut console = Console::new(arguments.farm.json);
    let farm = farm(&arguments.farm)?;
    let mut photos = Vec::new();
    let mut write = |frame: Frame, console: &Console| {
        let photo = write(&input.capture, &folder, &frame)?;
        console.line(&format!("{}  mean {}", photo.file, photo.mean.map(|m| format!("{m:.4}")).join(" ")));
        console.event(&serde_json::json!({ "event": "photo", "name": photo.name, "file": photo.file }));
        photos.push(photo);
        Ok(())
    };
    let traced = frames(&input, &farm, &arguments.options, &mut console, &interrupt, &mut write)?;
    let rendered = Rendered {
        capture: input.capture.name.clone(),
        samples: arguments.options.samples,
        seed: arguments.options.seed,
        seconds: begin.elapsed().as_secs_f64(),
        primary_samples: traced.primary_samples,
        invalid_samples: traced.invalid_samples,
        photos,
    };
    if arguments.farm.json {
        tell(&to_json(&rendered)?);
    } else {
        tell(&format!(
            "rendered {} of {} to {}: {} samples in {:.1} s",
            plural(rendered.photos.len(), "photo"),
            rendered.capture,
            folder.dir().display(),
            metric(count(rendered.primary_samples)),
            rendered.seconds
        ));
    }
    Ok(())
}

/// Indices of the photos with the given `names`, in the capture's order; of all where none is given.
pub(super) fn selection(capture: &Capture, names: &[String]) -> Result<Vec<usize>, Failure> {
    if let Some(unknown) = names.iter().find(|name| capture.photo_index(name).is_none()) {
        let known: Vec<&str> = capture.photos.iter().map(Photo::name).take(20).collect();
        let mend = format!("the photos are: {}", known.join(", "));
        return Err(SceneError::new("--photos", format!("names {unknown:?}, which is no photo"), mend).into());
    }
    let chosen = |name: &str| names.is_empty() || names.iter().any(|n| n == name);
    Ok(capture.photos.iter().enumerate().filter(|(_, photo)| chosen(photo.name())).map(|(i, _)| i).collect())
}

/// The files that are going to be written.
fn file_names(capture: &Capture, photos: &[usize]) -> Result<Vec<String>, Failure> {
    let mut names = BTreeSet::new();
    for photo in photos.iter().filter_map(|&i| capture.photos.get(i)) {
        for name in [format!("{}.exr", photo.name()), format!("{}.buffers.exr", photo.name())] {
            if !names.insert(name.clone()) {
                let problem = format!("would be written twice, as {name}");
                return Err(SceneError::new("capture.toml", problem, "rename one of the photos")
                    .at(photo.name())
                    .into());
            }
        }
    }
    Ok(names.into_iter().collect())
}

/// Writes a frame: a file that may stand for the photograph, and one of first hits.
fn write(capture: &Capture, folder: &Folder, frame: &Frame) -> Result<RenderedPhoto, Failure> {
    let film = &frame.image;
    let name = capture.photos.get(frame.photo).map_or("?", Photo::name).to_owned();
    let file = write_film(folder, &format!("{name}.exr"), film, &["R", "G", "B"])?;
    let hits = frame.buffers.as_ref();
    let buffers =
        hits.map(|film| write_film(folder, &format!("{name}.buffers.exr"), film, &FIRST_HIT_CHANNELS)).transpose()?;
    let mean = std::array::from_fn(|c| {
        film.channels.get(c).map_or(0.0, |values| {
            values.iter().map(|v| f64::from(*v)).sum::<f64>() / count(values.len() as u64).max(1.0)
        })
    });
    Ok(RenderedPhoto { name, file, buffers, width: film.width, height: film.height, mean })
}

fn write_film(folder: &Folder, name: &str, film: &Film, channels: &[&str]) -> Result<String, Failure> {
    let named: Vec<(&str, Vec<f32>)> = channels.iter().copied().zip(film.channels.iter().cloned()).collect();
    let bytes = encode_exr_channels(name, film.width, film.height, &named)?;
    Ok(folder.write(name, &bytes)?.display().to_string())
}
