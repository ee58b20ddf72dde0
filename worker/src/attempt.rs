//! One attempt at a task, from its arrival to the messages that end it.

use crate::Meter;
use crate::renderer::Scene;
use gonio_proto::convert::film::film_to_wire;
use gonio_proto::convert::task::{AttemptId, Task};
use gonio_proto::wire::{self, from_worker::Message};
use gonio_tracer::TileTask;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

/// Who has an attempt: a render thread that has claimed it, or nobody yet.
#[derive(Debug, Default)]
pub(crate) struct Claim {
    /// Set once, by whoever comes first: the render thread that begins, or the session that hands it back unrendered.
    taken: AtomicBool,
    /// Set once, when the attempt is over and its result is not wanted; the renderer looks at it.
    cancel: AtomicBool,
}

impl Claim {
    /// Whether the caller is the first to take it.
    pub fn take(&self) -> bool {
        !self.taken.swap(true, Ordering::AcqRel)
    }

    /// Ends the attempt, within a tile if it is being rendered.
    pub fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

/// Renders one task on a render thread; the messages that end the attempt, none if it was cancelled.
pub(crate) fn render(
    scene: &dyn Scene,
    task: &Task,
    first_hits: bool,
    claim: &Claim,
    meter: &Meter,
) -> Vec<wire::FromWorker> {
    let count = |counter: &AtomicU64| counter.fetch_add(1, Ordering::Relaxed);
    let rendered = catch_unwind(AssertUnwindSafe(|| film(scene, task, first_hits, claim, meter)));
    match rendered {
        Ok(Ok(Some(messages))) => messages,
        Ok(Ok(None)) => {
            count(&meter.cancelled);
            Vec::new()
        }
        Ok(Err(text)) => {
            count(&meter.failed);
            vec![failed(task.id, text)]
        }
        Err(_) => {
            count(&meter.failed);
            vec![failed(task.id, format!("rendering {} of photo {} panicked", task.id, task.photo))]
        }
    }
}

/// The film's messages, `None` if the attempt was cancelled, or why nobody can render the task.
fn film(
    scene: &dyn Scene,
    task: &Task,
    first_hits: bool,
    claim: &Claim,
    meter: &Meter,
) -> Result<Option<Vec<wire::FromWorker>>, String> {
    if claim.is_cancelled() {
        return Ok(None);
    }
    let start = Instant::now();
    let tile = TileTask {
        photo: task.photo,
        tile: task.tile,
        pixels: &task.pixels,
        samples: task.samples.clone(),
        seed: task.seed,
        difference_samples: task.difference_samples,
        forward_samples: task.forward_samples,
    };
    let cancel = &claim.cancel;
    let film = if first_hits { scene.first_hits(&tile, cancel) } else { scene.render(&tile, cancel) };
    match film {
        // Without a way out of the loop, so that it is a vector loop.
        Some(film) if film.data.iter().fold(true, |finite, value| finite & value.is_finite()) => {
            let time = start.elapsed();
            let per_pixel = if first_hits { 1 } else { 2 * task.samples.len() as u64 };
            meter.rendered(task.pixels.count() as u64 * per_pixel, time);
            Ok(Some(film_to_wire(task.id, &film, time).collect()))
        }
        Some(_) => Err(format!(
            "photo {}: the render overflows; lower the capture's radiances to the order of one",
            task.photo
        )),
        None if claim.is_cancelled() => Ok(None),
        None => Err(format!("photo {}: cannot be rendered, the capture has no such photo", task.photo)),
    }
}

/// Says that nobody can render a task.
pub(crate) fn failed(id: AttemptId, text: String) -> wire::FromWorker {
    said(Message::Failed(wire::TaskFailed { id: Some(id.into()), text }))
}

/// Says that a task was not rendered; an empty text: because the worker stops.
pub(crate) fn released(id: AttemptId, text: String) -> wire::FromWorker {
    said(Message::Released(wire::Released { id: Some(id.into()), text }))
}

pub(crate) fn said(message: Message) -> wire::FromWorker {
    wire::FromWorker { message: Some(message) }
}
