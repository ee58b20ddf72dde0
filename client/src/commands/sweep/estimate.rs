//! How long a sweep will take, from rendering a little of it.

use super::runner::Runner;
use crate::failure::Failure;
use crate::farm::OpenCapture;
use crate::progress::count;
use gonio_fit::{Evaluate, EvaluateError};
use gonio_scene::{EvaluationRequest, Output, Stream};
use gonio_sweep::Batch;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How long it goes on.
const TRIAL: Duration = Duration::from_secs(3);

/// Most batches that are tried.
const MOST: usize = 256;

/// Camera samples of one frame in a trial, where the frame has as many: small frames are rendered whole, so that what
/// each costs besides its samples counts too.
const SAMPLES: u64 = 2_000_000;

/// Camera samples a second of a few evenly spaced batches, `in_flight` at a time. The first frame of each stands for all.
///
/// # Errors
/// The farm fails or refuses, Ctrl-C.
pub(super) fn rate(
    runner: &Runner<'_>,
    open: &OpenCapture,
    batches: &[Batch],
    in_flight: usize,
) -> Result<f64, Failure> {
    let count_tried = batches.len().min(MOST);
    let tried: Vec<&Batch> = (0..count_tried).map(|i| &batches[i * batches.len() / count_tried]).collect();
    let (next, traced) = (AtomicUsize::new(0), AtomicU64::new(0));
    let failure = Mutex::new(None);
    let trial = |open: &mut OpenCapture, batch: &Batch| -> Result<(), EvaluateError> {
        let Some(frame) = batch.frames.first().map(|i| &runner.plan.frames[*i]) else { return Ok(()) };
        let affordable = u32::try_from(SAMPLES / runner.plan.pixels(frame).max(1)).unwrap_or(u32::MAX);
        let request = EvaluationRequest {
            numbers: runner.plan.numbers(frame),
            photos: vec![frame.photo],
            samples: (affordable / 2 * 2).clamp(2, runner.plan.samples),
            seed: Stream::Render.seed(frame.seed),
            output: Output::Films,
            ..EvaluationRequest::default()
        };
        let evaluation = open.evaluate(&request, &mut |_| runner.interrupt.flow())?;
        traced.fetch_add(evaluation.primary_samples, Ordering::Relaxed);
        Ok(())
    };
    // The first of all loads the capture, which happens once.
    let mut open = open.clone();
    if let Some(batch) = tried.first() {
        trial(&mut open, batch)?;
    }
    traced.store(0, Ordering::Relaxed);
    let begin = Instant::now();
    std::thread::scope(|scope| {
        for _ in 0..in_flight.min(tried.len()) {
            let mut open = open.clone();
            let (next, tried, trial, failure) = (&next, &tried, &trial, &failure);
            scope.spawn(move || {
                while begin.elapsed() < TRIAL
                    && let Some(batch) = tried.get(next.fetch_add(1, Ordering::Relaxed))
                {
                    if let Err(error) = trial(&mut open, batch) {
                        *failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(error);
                        return;
                    }
                }
            });
        }
    });
    if let Some(error) = failure.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
        return Err(error.into());
    }
    Ok(count(traced.load(Ordering::Relaxed)) / begin.elapsed().as_secs_f64().max(1e-9))
}
