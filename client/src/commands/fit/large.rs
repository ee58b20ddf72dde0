//! Captures of more pixels than a fit needs: which of them it compares, and pictures that are rendered small.

use crate::failure::Failure;
use crate::farm::OpenCapture;
use crate::input::Input;
use crate::progress::Console;
use crate::report::{LONGEST, Panel};
use gonio_design::{CELLS, preview, shrink};
use gonio_fit::{Evaluate, FitResult};
use gonio_scene::capture::{CAPTURE_FILE, Role};
use gonio_scene::design::Design;
use gonio_scene::files::Files;
use gonio_scene::{Capture, EvaluationRequest, Output, PhotoStatistics, Photograph, SceneError, Stream, Values};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Bytes of photographs that are decoded at the same time.
const DECODED_BYTES: u64 = 640 << 20;

/// Bytes that decoding takes for each pixel, its file's included; see the coordinator's cache, which counts the file by itself.
const BYTES_PER_PIXEL: u64 = 30;

/// Samples per pixel of a small picture: each stands for hundreds of the photo's pixels.
pub(super) const SAMPLES: u32 = 4;

/// A capture's files with another `capture.toml`, and without its photographs.
struct Small<'a> {
    files: &'a dyn Files,
    toml: Arc<[u8]>,
    hidden: BTreeSet<String>,
}

impl<'a> Small<'a> {
    fn new(capture: &Capture, files: &'a dyn Files) -> Result<Self, SceneError> {
        let photos = capture.photos.iter().flat_map(|photo| std::iter::once(&photo.file).chain(&photo.mask));
        Ok(Self { files, toml: Arc::from(capture.to_toml()?.into_bytes()), hidden: photos.cloned().collect() })
    }
}

impl Files for Small<'_> {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, SceneError> {
        if path == CAPTURE_FILE {
            return Ok(Arc::clone(&self.toml));
        }
        if self.hidden.contains(path) {
            let mend = "compare with the capture itself";
            return Err(SceneError::new(path, "is not part of a preview, which has fewer pixels", mend));
        }
        self.files.read(path)
    }
}

/// The photos of a large capture as small as they are shown, by index. Every one is read, so that an hour's fit does not end at a
/// photo that cannot be; as many at a time as memory allows.
///
/// # Errors
/// A file that is missing or broken.
pub(super) fn look(capture: &Capture, files: &dyn Files) -> Result<BTreeMap<usize, Values>, Failure> {
    let factors = preview(capture, LONGEST).factors;
    let all: Vec<_> = capture.targets().enumerate().collect();
    let pixels = |photo: usize| super::super::photo_pixels(capture, photo);
    let most = (0..capture.photos.len()).map(pixels).max().unwrap_or(0) * BYTES_PER_PIXEL;
    let at_once = usize::try_from(DECODED_BYTES / most.max(1)).unwrap_or(usize::MAX).clamp(1, all.len().max(1));
    let mut small = BTreeMap::new();
    for some in all.chunks(at_once) {
        let read = some.par_iter().map(|(index, target)| {
            let values = Values::of(capture, *target, files)?;
            Ok(factors.get(*index).map(|factor| (*index, shrink(&values, *factor))))
        });
        small.extend(read.collect::<Result<Vec<_>, SceneError>>()?.into_iter().flatten());
    }
    Ok(small)
}

/// The pixels to compare, about `wanted` of them, by what the cameras' rays hit first.
///
/// # Errors
/// The farm fails.
pub(super) fn design(
    capture: &Capture,
    files: &dyn Files,
    farm: &OpenCapture,
    seed: u64,
    wanted: u64,
) -> Result<Design, Failure> {
    let small = preview(capture, CELLS).capture;
    let mut farm = farm.beside(&Small::new(&small, files)?)?;
    let request = EvaluationRequest {
        photos: (0..capture.photos.len()).collect(),
        samples: 2,
        output: Output::FirstHit,
        ..EvaluationRequest::default()
    };
    let hits = farm.evaluate(&request, &mut |_| ControlFlow::Continue(()))?.films;
    Ok(gonio_design::choose(capture, &hits, seed, wanted))
}

/// A panel for each photo of the `fitted` capture, rendered as small as it is shown. The fit's own comparison is told beside it; that of
/// held-out photos is made here.
///
/// # Errors
/// The farm fails, Ctrl-C.
pub(super) fn panels(
    input: &Input,
    farm: &mut OpenCapture,
    result: &FitResult,
    photos: &BTreeMap<usize, Values>,
    console: &mut Console,
    flow: &dyn Fn() -> ControlFlow<()>,
) -> Result<Vec<Panel>, Failure> {
    let fitted = &input.capture;
    let numbers: Vec<(String, f64)> = fitted
        .free_parameters()?
        .iter()
        .flat_map(|parameter| parameter.numbers(parameter.value).collect::<Vec<_>>())
        .collect();
    let held_out = (0..fitted.photos.len()).filter(|photo| fitted.photos[*photo].role == Role::HeldOut).collect();
    let mut evaluate = |farm: &mut OpenCapture, request: &EvaluationRequest| {
        farm.evaluate(request, &mut |progress| {
            console.advance(progress.tasks_done, progress.tasks, progress);
            flow()
        })
    };
    let request = EvaluationRequest {
        photos: held_out,
        samples: result.samples,
        seed: Stream::Fit.seed(result.seed),
        ..Default::default()
    };
    let mut statistics: BTreeMap<usize, PhotoStatistics> =
        result.photos.iter().map(|photo| (photo.photo, photo.clone())).collect();
    if !request.photos.is_empty() {
        let held_out = evaluate(farm, &EvaluationRequest { numbers, ..request })?;
        statistics.extend(held_out.photos.into_iter().map(|photo| (photo.photo, photo)));
    }
    let small = preview(fitted, LONGEST);
    let request = EvaluationRequest {
        photos: (0..fitted.photos.len()).collect(),
        samples: SAMPLES,
        seed: Stream::Fit.seed(result.seed),
        output: Output::Films,
        ..EvaluationRequest::default()
    };
    let mut preview_farm = farm.beside(&Small::new(&small.capture, input)?)?;
    let films = evaluate(&mut preview_farm, &request)?.films;
    let panel = |film: &gonio_scene::Film| {
        let values = photos.get(&film.photo)?;
        let photograph = Photograph::new(values.image.clone(), values.counts.clone(), values.clipped);
        let panel = Panel::new(&small.capture, &photograph, film, statistics.get(&film.photo)?)?;
        Some(panel.shrunk(small.factors[film.photo]))
    };
    Ok(films.iter().filter_map(panel).collect())
}
