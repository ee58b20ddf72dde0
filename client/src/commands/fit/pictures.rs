//! The report's pictures: every photo rendered once more, at the fitted values, with all of its pixels.

use super::super::{batches, photo_pixels};
use super::large;
use crate::failure::Failure;
use crate::farm::OpenCapture;
use crate::input::Input;
use crate::interrupt::Interrupt;
use crate::progress::Console;
use crate::report::{Panel, ReflectancePanel};
use gonio_fit::{Evaluate, FitResult};
use gonio_scene::capture::Target;
use gonio_scene::reflectance::Directions;
use gonio_scene::{Capture, EvaluationRequest, Output, Photograph, Stream, Values};
use std::collections::BTreeMap;

/// What a report shows of a fit.
#[derive(Debug, Default)]
pub struct Pictures {
    /// The photos.
    pub photos: Vec<Panel>,
    /// The files of measured reflectance.
    pub files: Vec<ReflectancePanel>,
}

/// Fewest samples per pixel of a picture, where the fit itself took as many.
const FEWEST: u32 = 16;

/// Samples per pixel of the pictures: as many as the fit's last, unless they would cost more than a quarter of it.
pub(super) fn samples(capture: &Capture, result: &FitResult) -> u32 {
    let pixels: u64 = (0..capture.photos.len()).map(|photo| photo_pixels(capture, photo)).sum();
    let quarter = u32::try_from(result.primary_samples / 4 / pixels.max(1)).unwrap_or(u32::MAX);
    // Even, as each half takes as many.
    quarter.max(FEWEST).min(result.samples) / 2 * 2
}

/// A panel for each photo, and file of reflectance, of the `fitted` capture, the held-out included: no value follows from them any more.
/// `small` are the photos of a capture of which not all pixels were compared: those are rendered small.
///
/// # Errors
/// The farm fails, a photograph has changed since, Ctrl-C.
pub(super) fn all(
    fitted: &Input,
    farm: &mut OpenCapture,
    result: &FitResult,
    small: &BTreeMap<usize, Values>,
    console: &mut Console,
    interrupt: &Interrupt,
) -> Result<Pictures, Failure> {
    let targets: Vec<usize> =
        (0..fitted.capture.targets().count()).filter(|target| !small.contains_key(target)).collect();
    let mut pictures = panels(fitted, &targets, farm, result, console, interrupt)?;
    if !small.is_empty() {
        console.begin("pictures");
        let flow = || interrupt.flow();
        pictures.photos.extend(large::panels(fitted, farm, result, small, console, &flow)?);
    }
    Ok(pictures)
}

fn panels(
    input: &Input,
    photos: &[usize],
    farm: &mut dyn Evaluate,
    result: &FitResult,
    console: &mut Console,
    interrupt: &Interrupt,
) -> Result<Pictures, Failure> {
    let fitted = &input.capture;
    let numbers: Vec<(String, f64)> = fitted
        .free_parameters()?
        .iter()
        .flat_map(|parameter| parameter.numbers(parameter.value).collect::<Vec<_>>())
        .collect();
    let mut pictures = Pictures::default();
    let mut done = 0;
    for batch in batches(fitted, photos) {
        let request = EvaluationRequest {
            numbers: numbers.clone(),
            columns: Vec::new(),
            photos: batch,
            samples: samples(fitted, result),
            difference_samples: 0,
            forward_samples: 0,
            seed: Stream::Fit.seed(result.seed),
            output: Output::StatisticsAndFilms,
        };
        console.begin(&format!("pictures {}-{} of {}", done + 1, done + request.photos.len(), photos.len()));
        let evaluation = farm.evaluate(&request, &mut |progress| {
            console.advance(progress.tasks_done, progress.tasks, progress);
            interrupt.flow()
        })?;
        for (film, statistics) in evaluation.films.iter().zip(&evaluation.photos) {
            let Some(target) = fitted.target(statistics.photo) else { continue };
            let photograph = Photograph::of(fitted, target, input)?;
            if let Target::Reflectance(file) = target {
                let pairs = Directions::read(input, &file.file)?.pairs;
                pictures.files.extend(ReflectancePanel::new(fitted, &photograph, &pairs, film, statistics));
            } else {
                pictures.photos.extend(Panel::new(fitted, &photograph, film, statistics));
            }
        }
        done += evaluation.photos.len();
    }
    if pictures.photos.len() + pictures.files.len() < photos.len() {
        console.line("some photos changed while they were fitted, and are left out of the report");
    }
    Ok(pictures)
}
