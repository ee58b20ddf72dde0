//! What a client sees of its evaluation.

use super::prepare::prepare;
use crate::Coordinator;
use crate::broker::{Active, Failure};
use crate::intake::Turn;
use gonio_proto::convert::event::{Event, film_chunks};
use gonio_proto::convert::request::Requester;
use gonio_proto::{Digest, wire};
use gonio_scene::{EvaluationRequest, Progress};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

/// Time between two progress events.
const PROGRESS: Duration = Duration::from_millis(100);

/// Events that wait for a slow client; more wait at their source.
const EVENTS: usize = 8;

/// Runs an evaluation for as long as somebody reads its events.
pub fn evaluate(
    coordinator: Coordinator,
    turn: Turn,
    requester: Requester,
    digest: Digest,
    request: EvaluationRequest,
) -> ReceiverStream<wire::EvaluationEvent> {
    let (events, receiver) = mpsc::channel(EVENTS);
    tokio::spawn(async move {
        let evaluation = coordinator.broker.new_evaluation();
        tracing::info!(evaluation, client = requester.client, class = ?requester.class, capture = %digest, photos = request.photos.len(), samples = request.samples, "accepted");
        let end = tokio::select! {
            end = run(&coordinator, evaluation, requester, digest, request, &events) => end,
            () = events.closed() => Err(Failure::of_farm("the client is gone")),
        };
        let counters = coordinator.broker.counters();
        match end {
            Ok(()) => tracing::info!(evaluation, ?counters, "finished"),
            Err(Failure { request_at_fault, text }) => {
                tracing::info!(evaluation, ?counters, text, "failed");
                let _ = events.send(Event::Failed { request_at_fault, text }.into()).await;
            }
        }
        drop(turn);
    });
    ReceiverStream::new(receiver)
}

/// A client that is gone is noticed by [`evaluate`]; here a failed send is only the end of the sending.
async fn run(
    coordinator: &Coordinator,
    evaluation: u64,
    requester: Requester,
    digest: Digest,
    request: EvaluationRequest,
    events: &mpsc::Sender<wire::EvaluationEvent>,
) -> Result<(), Failure> {
    let _ = events.send(Event::Accepted(evaluation).into()).await;
    let broker = &coordinator.broker;
    let (active, mut outcome) = prepare(&coordinator.captures, evaluation, requester, digest, request).await?;
    let registration = broker.submit(Arc::clone(&active));
    let mut ticks = tokio::time::interval(PROGRESS);
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    loop {
        tokio::select! {
            ended = &mut outcome => {
                ended.map_err(Failure::of_farm)??;
                break;
            }
            _ = ticks.tick() => {
                let progress = with_loss(broker.progress(evaluation), &active);
                let _ = events.send(Event::Progress(progress).into()).await;
            }
        }
    }
    let last = with_loss(broker.progress(evaluation), &active);
    let _ = events.send(Event::Progress(last).into()).await;
    drop(registration);
    let answer = tokio::task::spawn_blocking(move || active.reduction.finish()).await.map_err(Failure::of_farm)?;
    let answer = answer.map_err(Failure::of_request)?;
    let finished = Event::Finished { primary_samples: last.primary_samples, invalid_samples: answer.invalid_samples };
    for statistics in answer.photos {
        let _ = events.send(Event::Statistics(statistics).into()).await;
    }
    for film in answer.films {
        for chunk in film_chunks(&film) {
            let _ = events.send(chunk.into()).await;
        }
    }
    let _ = events.send(finished.into()).await;
    Ok(())
}

#[allow(clippy::cast_precision_loss)]
fn with_loss(progress: Progress, active: &Active) -> Progress {
    let running = active.reduction.running();
    let observations = running.observations.max(1) as f64;
    let (loss, error) = (running.loss / observations, running.loss_variance.sqrt() / observations);
    let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
    Progress { loss: finite(loss), loss_standard_error: finite(error), ..progress }
}
