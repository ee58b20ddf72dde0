//! Residuals at full size, for who wants to look at every pixel.

use crate::failure::Failure;
use crate::input::Input;
use crate::output::Output as Folder;
use crate::progress::Console;
use gonio_fit::{Evaluate, FitResult};
use gonio_scene::image::{Image, encode_exr};
use gonio_scene::{EvaluationRequest, Output, SensorStage, Stream, Values};
use std::ops::ControlFlow;

/// Samples per pixel of the renders, at most: the file's own noise is as large.
const SAMPLES: u32 = 16;

/// The file of a photo's residual.
pub(super) fn name(photo: &str) -> String {
    format!("residual-{photo}.exr")
}

/// Renders every photo of the `fitted` capture at full size, one at a time, and writes photo minus render, in photo values; 0 where
/// a pixel does not count.
///
/// # Errors
/// The farm fails, a photo cannot be read any more, the folder cannot be written to, Ctrl-C.
pub(super) fn write(
    input: &Input,
    farm: &mut dyn Evaluate,
    result: &FitResult,
    folder: &Folder,
    console: &mut Console,
    flow: &dyn Fn() -> ControlFlow<()>,
) -> Result<(), Failure> {
    let fitted = &input.capture;
    let numbers: Vec<(String, f64)> = fitted
        .free_parameters()?
        .iter()
        .flat_map(|parameter| parameter.numbers(parameter.value).collect::<Vec<_>>())
        .collect();
    for (index, target) in fitted.targets().enumerate().take(fitted.photos.len()) {
        console.begin(&format!("residual {} of {}", index + 1, fitted.photos.len()));
        let request = EvaluationRequest {
            numbers: numbers.clone(),
            photos: vec![index],
            samples: SAMPLES,
            seed: Stream::Fit.seed(result.seed),
            output: Output::Films,
            ..EvaluationRequest::default()
        };
        let films = farm
            .evaluate(&request, &mut |progress| {
                console.advance(progress.tasks_done, progress.tasks, progress);
                flow()
            })?
            .films;
        let Some(film) = films.first() else { continue };
        let render = SensorStage::of(fitted, index).photo_values(film);
        let Values { image, counts, .. } = Values::of(fitted, target, input)?;
        let residual = |(place, (pixel, counts)): (usize, (&[f32; 3], &bool))| {
            [0, 1, 2].map(|c| if *counts { pixel[c] - render.channels[c][place] } else { 0.0 })
        };
        let pixels = image.pixels.iter().zip(&counts).enumerate().map(residual).collect();
        let name = name(target.name());
        folder.write(&name, &encode_exr(&name, &Image { pixels, ..image })?)?;
    }
    Ok(())
}
