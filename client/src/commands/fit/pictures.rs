//! The report's pictures: every photo rendered once more, at the fitted values, with all of its pixels.

use super::super::batches;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::progress::Console;
use gonio::report::Panel;
use gonio_fit::{Evaluate, FitResult};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::{Capture, EvaluationRequest, Output, Photograph};

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
            samples: result.samples,
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
