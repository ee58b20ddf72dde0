//! From a request to tasks and their reduction.

use super::cache::{Asking, Captures};
use crate::aggregate::reduction::ReducedPhoto;
use crate::aggregate::{Measured, Recipe, Reduction};
use crate::broker::{Active, Failure, Outcome};
use crate::journal::Journal;
use crate::split::{PhotoArea, Split};
use futures::{FutureExt, StreamExt, TryStreamExt};
use gonio_proto::convert::request::Requester;
use gonio_proto::convert::task::Setup;
use gonio_proto::{Digest, Key, limits};
use gonio_scene::derivative::Plan;
use gonio_scene::{Capture, EvaluationRequest, MAX_SIDE, Output};
use std::sync::Arc;
use tokio::sync::oneshot;

/// Photographs of one evaluation that are asked for at the same time; how many are decoded at once depends on their size.
const PHOTOGRAPHS_AT_ONCE: usize = 4;

/// An evaluation that is ready to be worked on, and where its outcome will be told.
pub type Prepared = (Arc<Active>, oneshot::Receiver<Outcome>);

/// What is asked for: the capture's and the design's digest, and the request.
pub struct Asked {
    /// The capture's manifest.
    pub capture: Digest,
    /// The design of what is compared; absent, all is.
    pub design: Option<Digest>,
    /// All else.
    pub request: EvaluationRequest,
}

/// Reads the capture and the photographs that are compared with, no others, and splits the evaluation. With a keeper, its
/// tiles are written down.
///
/// # Errors
/// A name, photo or value that the capture does not have or allow; a file that is missing or broken; more than the
/// farm takes.
pub async fn prepare(
    captures: &Captures,
    evaluation: u64,
    requester: Requester,
    asked: Asked,
    keeper: Option<(Journal, Key)>,
) -> Result<Prepared, Failure> {
    let Asked { capture: digest, design, request } = asked;
    let described = captures.describe(digest).await?;
    let design = match design {
        Some(digest) => Some((digest, captures.design(digest).await?)),
        None => None,
    };
    let mut capture = described.capture.clone();
    capture.set_numbers(&request.numbers).map_err(Failure::of_request)?;
    let targets = capture.targets().count();
    if targets > limits::PHOTOS {
        return Err(Failure::of_request(format!("capture.toml has more than {} photos", limits::PHOTOS)));
    }
    if let Some(index) = request.photos.iter().find(|index| **index >= targets) {
        return Err(Failure::of_request(format!("photo {index}: the capture has {targets} photos")));
    }
    let plan = Plan::new(&capture, &request.columns).map_err(Failure::of_request)?;
    let capture = Arc::new(capture);

    // Reflectance is read in any case: a film of it has as many pixels as its file has samples.
    let wanted = |index: usize| request.output.compares() || index >= capture.photos.len();
    let read = |index: &usize| {
        let (captures, described, capture, design, index) = (captures, &described, &capture, design.as_ref(), *index);
        async move {
            let Some(index) = Some(index).filter(|index| wanted(*index)) else { return Ok(None) };
            let of = Asking { digest, described, capture, design, index };
            captures.photograph(of).await.map(Some)
        }
        .boxed()
    };
    // Made at once but begun in turn: a future does nothing until it is polled.
    let reads: Vec<_> = request.photos.iter().map(read).collect();
    let photographs: Vec<_> = futures::stream::iter(reads).buffered(PHOTOGRAPHS_AT_ONCE).try_collect().await?;
    let compares = request.output.compares();
    let trace_parent = gonio_operations::trace_parent();
    let cpu = move || {
        let mut photos = Vec::with_capacity(photographs.len());
        for (index, photograph) in request.photos.iter().zip(photographs) {
            let (width, height) = size(&capture, *index, photograph.as_deref())?;
            let photograph = photograph.filter(|_| compares);
            let peak = photograph.as_deref().map_or(0.0, Measured::peak);
            let recipe = Recipe::new(&plan, &capture, *index);
            let sensor = capture.sensor_of(*index);
            photos.push(ReducedPhoto { index: *index, width, height, recipe, sensor, photograph, peak });
        }
        let only_counted = request.output == Output::Statistics;
        let areas: Vec<_> = photos.iter().map(|photo| area(photo, only_counted)).collect();
        let split = Split::new(&areas, request.samples, request.output, plan.planes.len());
        let split = split.map_err(Failure::of_request)?;
        let split = Arc::new(split.with_derivative_samples(request.difference_samples, request.forward_samples));
        let reduction = Reduction::new(request.output, Arc::clone(&split), photos);
        let first_hits = request.output == Output::FirstHit;
        // First hits depend on no derivative: without columns, workers find the scene that they prepared before.
        let columns = if first_hits { Vec::new() } else { request.columns };
        let class = requester.class;
        let numbers = request.numbers;
        let setup = Setup { evaluation, capture: digest, numbers, columns, first_hits, class, trace_parent };
        let (active, outcome) = Active::new(requester, setup, split, request.photos, request.seed, reduction);
        let active = match keeper {
            Some((journal, key)) => active.kept(journal, key),
            None => active,
        };
        Ok((Arc::new(active), outcome))
    };
    tokio::task::spawn_blocking(cpu).await.map_err(Failure::of_farm)?
}

/// Width and height of a photo, or of measured reflectance that has been read.
fn size(capture: &Capture, index: usize, photograph: Option<&Measured>) -> Result<(u32, u32), Failure> {
    let Some(photo) = capture.photos.get(index) else {
        return Ok(photograph.map_or((0, 0), Measured::size));
    };
    let camera = capture.camera_of(photo);
    let (width, height) = (camera.width, camera.height);
    if width.max(height) > MAX_SIDE {
        let text = format!("photo {}: has {width}x{height} pixels, at most {MAX_SIDE} a side", photo.name());
        return Err(Failure::of_request(text));
    }
    Ok((width, height))
}

fn area(photo: &ReducedPhoto, only_counted: bool) -> PhotoArea<'_> {
    let counted = photo.photograph.as_deref().filter(|_| only_counted);
    PhotoArea { width: photo.width, height: photo.height, counted }
}
