//! What a client hears of its evaluation.

use crate::Coordinator;
use crate::broker::Active;
use crate::jobs::{Answer, Job, Listener};
use gonio_proto::convert::event::{Event, film_chunks};
use gonio_proto::wire;
use gonio_scene::Progress;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc;

/// Time between two progress events.
const PROGRESS: Duration = Duration::from_millis(100);

type Events = mpsc::Sender<wire::EvaluationEvent>;

/// Tells a client all about an evaluation, from now to its end; returns early where the client is gone, or the coordinator
/// stops.
pub(super) async fn tell(coordinator: &Coordinator, job: &Arc<Job>, _listener: Listener, events: &Events) {
    tokio::select! {
        () = follow(coordinator, job, events) => {}
        () = events.closed() => {}
        // Without a last event: it goes on elsewhere.
        () = coordinator.intake.cut(), if job.key.is_some() => {}
    }
}

async fn follow(coordinator: &Coordinator, job: &Arc<Job>, events: &Events) {
    let _ = events.send(Event::Accepted(job.evaluation).into()).await;
    let mut ticks = tokio::time::interval(PROGRESS);
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    let end = loop {
        tokio::select! {
            end = job.ended() => break end,
            _ = ticks.tick() => {
                if job.active.get().is_some() {
                    let _ = events.send(Event::Progress(progress(coordinator, job)).into()).await;
                }
            }
        }
    };
    match end.as_deref() {
        Some(Ok(answer)) => send(answer, events).await,
        Some(Err(failure)) => {
            let failed = Event::Failed { request_at_fault: failure.request_at_fault, text: failure.text.clone() };
            let _ = events.send(failed.into()).await;
        }
        None => {}
    }
    if job.key.is_some() {
        // The answer is delivered once the client's stream has taken all of it, and closes.
        if events.reserve_many(events.max_capacity()).await.is_ok() {
            job.deliver();
        }
    }
}

async fn send(answer: &Answer, events: &Events) {
    let _ = events.send(Event::Progress(answer.progress).into()).await;
    for statistics in &answer.evaluation.photos {
        let _ = events.send(Event::Statistics(statistics.clone()).into()).await;
    }
    for film in &answer.evaluation.films {
        for chunk in film_chunks(film) {
            let _ = events.send(chunk.into()).await;
        }
    }
    let (primary_samples, invalid_samples) = (answer.progress.primary_samples, answer.evaluation.invalid_samples);
    let _ = events.send(Event::Finished { primary_samples, invalid_samples }.into()).await;
}

/// How far an evaluation is.
#[must_use]
pub fn progress(coordinator: &Coordinator, job: &Job) -> Progress {
    let progress = coordinator.broker.progress(job.evaluation);
    job.active.get().map_or(progress, |active| with_loss(progress, active))
}

pub(super) fn with_loss(progress: Progress, active: &Active) -> Progress {
    let running = active.reduction.running();
    let floor = running.noise_floor.max(f64::MIN_POSITIVE);
    let (loss, error) = (running.loss / floor, running.loss_variance.sqrt() / floor);
    let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
    Progress { loss: finite(loss), loss_standard_error: finite(error), ..progress }
}
