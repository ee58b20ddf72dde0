//! The report's pictures: every photo rendered once more, at the fitted values, with all of its pixels.

use super::super::{batches, photo_pixels};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::progress::Console;
use gonio::report::Panel;
use gonio_fit::{Evaluate, FitResult};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::{Capture, EvaluationRequest, Output, Photograph};

/// Fewest samples per pixel of a picture, where the fit itself took as many.
const FEWEST: u32 = 16;

/// Samples per pixel of the pictures: as many as the fit's last, unless they would cost more than a quarter of it.
pub(super) fn samples(capture: &Capture, result: &FitResult) -> u32 {
    let pixels: u64 = (0..capture.photos.len()).map(|photo| photo_pixels(capture, photo)).sum();
    let quarter = u32::try_from(result.primary_samples / 4 / pixels.max(1)).unwrap_or(u32::MAX);
    // Even, as each half takes as many.
    quarter.max(FEWEST).min(result.samples) / 2 * 2
}

/// A panel for each photo of the `fitted` capture, the held-out included: no value follows from them any more.
///
/// # Errors
/// The farm fails, a photograph has changed since, Ctrl-C.
pub(super) fn panels(
    fitted: &Capture,
    files: &DirectoryFiles,
    farm: &mut dyn Evaluate,
    result: &FitResult,
    console: &mut Console,
    interrupt: &Interrupt,
) -> Result<Vec<Panel>, Failure> {
    let numbers: Vec<(String, f64)> = fitted
        .free_parameters()?
        .iter()
        .flat_map(|parameter| parameter.numbers(parameter.value).collect::<Vec<_>>())
        .collect();
    let photos: Vec<usize> = (0..fitted.photos.len()).collect();
    let mut panels = Vec::new();
    for batch in batches(fitted, &photos) {
        let done = panels.len();
        let request = EvaluationRequest {
            numbers: numbers.clone(),
            columns: Vec::new(),
            photos: batch,
            samples: samples(fitted, result),
            difference_samples: 0,
            seed: result.seed,
            output: Output::StatisticsAndFilms,
        };
        console.begin(&format!("pictures {}-{} of {}", done + 1, done + request.photos.len(), photos.len()));
        let evaluation = farm.evaluate(&request, &mut |progress| {
            console.advance(progress.tasks_done, progress.tasks, progress);
            interrupt.flow()
        })?;
        for (film, statistics) in evaluation.films.iter().zip(&evaluation.photos) {
            let Some(photo) = fitted.photos.get(statistics.photo) else { continue };
            let photograph = Photograph::load(fitted, photo, files)?;
            panels.extend(Panel::new(fitted, &photograph, film, statistics));
        }
    }
    if panels.len() < photos.len() {
        console.line("some photos changed while they were fitted, and are left out of the report");
    }
    Ok(panels)
}
