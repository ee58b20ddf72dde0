//! `gonio render`: films, and first-hit buffers, as OpenEXR.

use super::{batches, open, photo_pixels};
use crate::arguments::RenderArguments;
use crate::failure::Failure;
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

/// Renders and writes.
///
/// # Errors
/// A broken capture, a farm that fails, a folder that cannot be written to, Ctrl-C.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    let begin = Instant::now();
    let interrupt = Interrupt::listen(if arguments.farm.json { "" } else { "stopping; again to kill" })?;
    let input = Input::open(&arguments.capture)?;
    let photos = selection(&input.capture, &arguments.photos)?;
    let folder = Folder::create(&arguments.out, &file_names(&input.capture, &photos)?, &input.root, &input.capture)?;
    let mut console = Console::new(arguments.farm.json);
    let mut farm = open(&arguments.farm, &input)?;

    let samples = u64::from(arguments.samples);
    let total: u64 = photos.iter().map(|&photo| photo_pixels(&input.capture, photo).saturating_mul(samples)).sum();
    console.begin("rendering");
    let mut rendered = Rendered {
        capture: input.capture.name.clone(),
        samples: arguments.samples,
        seed: arguments.seed,
        seconds: 0.0,
        primary_samples: 0,
        invalid_samples: 0,
        photos: Vec::new(),
    };
    for batch in batches(&input.capture, &photos) {
        let mut evaluate = |output: Output, done: u64| -> Result<Evaluation, Failure> {
            let request = EvaluationRequest {
                numbers: Vec::new(),
                columns: Vec::new(),
                photos: batch.clone(),
                samples: if output == Output::FirstHit { 2 } else { arguments.samples },
                difference_samples: 0,
                forward_samples: 0,
                seed: Stream::Render.seed(arguments.seed),
                output,
            };
            Ok(farm.evaluate(&request, &mut |progress| {
                let mut overall = *progress;
                if output == Output::FirstHit {
                    overall.primary_samples = 0;
                }
                overall.primary_samples += done;
                console.advance(overall.primary_samples, total, &overall);
                interrupt.flow()
            })?)
        };
        let films = evaluate(Output::Films, rendered.primary_samples)?;
        rendered.primary_samples += films.primary_samples;
        rendered.invalid_samples += films.invalid_samples;
        let buffers =
            if arguments.buffers { evaluate(Output::FirstHit, rendered.primary_samples)?.films } else { Vec::new() };
        for (i, film) in films.films.iter().enumerate() {
            let photo = write(&input.capture, &folder, film, buffers.get(i))?;
            console.line(&format!("{}  mean {}", photo.file, photo.mean.map(|m| format!("{m:.4}")).join(" ")));
            console.event(&serde_json::json!({ "event": "photo", "name": photo.name, "file": photo.file }));
            rendered.photos.push(photo);
        }
    }
    console.end();
    if rendered.invalid_samples > 0 {
        console.line(&format!(
            "warning: {} were NaN or infinite and count as black",
            plural(usize::try_from(rendered.invalid_samples).unwrap_or(usize::MAX), "sample")
        ));
    }
    rendered.seconds = begin.elapsed().as_secs_f64();
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
fn selection(capture: &Capture, names: &[String]) -> Result<Vec<usize>, Failure> {
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

/// Writes a film as photo values: a file that may stand for the photograph.
fn write(capture: &Capture, folder: &Folder, film: &Film, buffers: Option<&Film>) -> Result<RenderedPhoto, Failure> {
    let film = &SensorStage::of(capture, film.photo).photo_values(film);
    let name = capture.photos.get(film.photo).map_or("?", Photo::name).to_owned();
    let file = write_film(folder, &format!("{name}.exr"), film, &["R", "G", "B"])?;
    let buffers = buffers
        .map(|film| write_film(folder, &format!("{name}.buffers.exr"), film, &FIRST_HIT_CHANNELS))
        .transpose()?;
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
