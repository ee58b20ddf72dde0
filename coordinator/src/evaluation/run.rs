//! The life of an evaluation: accepted, run by a task of its own, listened to, over.

use super::prepare::{Asked, prepare};
use super::stream::{tell, with_loss};
use crate::Coordinator;
use crate::broker::Failure;
use crate::intake::Turn;
use crate::jobs::{Answer, Job, MOST};
use crate::journal::Restored;
use gonio_proto::convert::design::design_of;
use gonio_proto::convert::reduced::Reduced;
use gonio_proto::convert::request::{Requester, request_from_wire};
use gonio_proto::{Digest, Key, WireError, wire};
use gonio_scene::EvaluationRequest;
use prost::Message;
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Status;
use tracing::Instrument;

/// Events that wait for a slow client; more wait at their source.
const EVENTS: usize = 8;

/// Why an evaluation ends that nobody listens to.
const GONE: &str = "the client is gone";

/// A request that has been checked.
struct Checked {
    message: wire::EvaluationRequest,
    request: EvaluationRequest,
    capture: Digest,
    design: Option<Digest>,
    requester: Requester,
    key: Option<Key>,
}

impl Checked {
    fn new(message: wire::EvaluationRequest) -> Result<Self, WireError> {
        let requester = Requester::of(&message)?;
        let key = Key::from_wire("EvaluationRequest.key", &message.key)?;
        let design = design_of(&message)?;
        let (capture, request) = request_from_wire(message.clone())?;
        Ok(Self { message, request, capture, design, requester, key })
    }

    fn job(&self, evaluation: u64) -> Job {
        let digest = Digest::of(&self.message.encode_to_vec());
        Job::new(self.key, digest, evaluation, self.requester.clone(), self.capture)
    }
}

/// Runs an evaluation, or listens to the one that has its key. `caller` is the span that asks, as a W3C traceparent, or empty.
///
/// # Errors
/// A request that breaks the protocol, or has the key of another; a coordinator that takes none any more.
pub fn evaluate(
    coordinator: Coordinator,
    message: wire::EvaluationRequest,
    caller: &str,
) -> Result<ReceiverStream<wire::EvaluationEvent>, Status> {
    let checked = Checked::new(message)?;
    if coordinator.jobs.is_full_for(checked.key) {
        let text = format!("{MOST} evaluations run already; send fewer at a time, or ask again when some have ended");
        return Err(Status::resource_exhausted(text));
    }
    let turn = coordinator.intake.enter().ok_or_else(|| Status::unavailable(crate::STOPS))?;
    let job = checked.job(coordinator.broker.new_evaluation());
    let asked = job.request;
    let (events, receiver) = mpsc::channel(EVENTS);
    let (job, new) = match coordinator.jobs.add(job) {
        Ok(job) => (job, true),
        Err(job) if job.request == asked => (job, false),
        Err(_) => return Err(WireError::new("EvaluationRequest.key", "is that of another evaluation").into()),
    };
    // Before it begins: nobody must take it for abandoned.
    let listener = job.listen();
    if new {
        let span = tracing::info_span!("evaluation", evaluation = job.evaluation, client = checked.requester.client);
        gonio_operations::follow(&span, caller);
        tokio::spawn(accept(coordinator.clone(), Arc::clone(&job), checked, turn).instrument(span));
    }
    tokio::spawn(async move { tell(&coordinator, &job, listener, &events).await });
    Ok(ReceiverStream::new(receiver))
}

/// Goes on with an evaluation of an earlier coordinator.
pub(crate) fn resume(coordinator: &Coordinator, restored: Restored) {
    let Restored { key, request, tiles } = restored;
    let (checked, turn) = match (Checked::new(request), coordinator.intake.enter()) {
        (Ok(checked), Some(turn)) => (checked, turn),
        (Err(error), _) => {
            tracing::warn!(%key, %error, "an evaluation of the journal is not taken over");
            return;
        }
        (_, None) => return,
    };
    let Ok(job) = coordinator.jobs.add(checked.job(coordinator.broker.new_evaluation())) else { return };
    tracing::info!(evaluation = job.evaluation, %key, tiles = tiles.len(), "taken over");
    tokio::spawn(run(coordinator.clone(), job, checked, tiles, turn));
}

async fn accept(coordinator: Coordinator, job: Arc<Job>, checked: Checked, turn: Turn) {
    let Checked { requester, request, capture, .. } = &checked;
    tracing::info!(evaluation = job.evaluation, client = requester.client, class = ?requester.class, %capture, photos = request.photos.len(), samples = request.samples, "accepted");
    if let (Some(journal), Some(key)) = (&coordinator.journal, job.key)
        && !journal.accept(key, checked.message.clone()).await
    {
        // The farm is another's: this coordinator is about to stop, and the client asks there.
        coordinator.intake.cut().await;
        coordinator.jobs.remove(&job);
        return;
    }
    run(coordinator, job, checked, BTreeMap::new(), turn).await;
}

async fn run(coordinator: Coordinator, job: Arc<Job>, checked: Checked, tiles: BTreeMap<u64, Reduced>, turn: Turn) {
    let end = tokio::select! {
        biased;
        // It goes on elsewhere: nothing is written down.
        () = coordinator.intake.cut(), if job.key.is_some() => None,
        end = work(&coordinator, &job, checked, tiles) => Some(end),
        () = job.abandoned() => Some(Err(Failure::of_farm(GONE))),
        why = job.cancelled() => Some(Err(Failure::of_request(why))),
    };
    let counters = coordinator.broker.counters();
    let Some(end) = end else {
        tracing::info!(evaluation = job.evaluation, ?counters, "left to the next coordinator");
        coordinator.jobs.remove(&job);
        drop(turn);
        return;
    };
    match &end {
        Ok(_) => tracing::info!(evaluation = job.evaluation, ?counters, "finished"),
        Err(Failure { text, .. }) => tracing::info!(evaluation = job.evaluation, ?counters, text, "failed"),
    }
    if let Some(key) = job.key {
        // Nobody who listens: then nobody has for long enough.
        let given_up = matches!(&end, Err(failure) if failure.text == GONE) && job.listeners() == 0;
        job.finish(end);
        tokio::select! {
            () = std::future::ready(()), if given_up => {}
            () = job.delivered() => {}
            () = job.abandoned() => {}
            () = coordinator.intake.cut() => {}
        }
        coordinator.jobs.remove(&job);
        if let Some(journal) = &coordinator.journal {
            journal.over(key).await;
        }
    } else {
        job.finish(end);
        // Those who listen have the job itself.
        coordinator.jobs.remove(&job);
        job.abandoned().await;
    }
    drop(turn);
}

async fn work(
    coordinator: &Coordinator,
    job: &Arc<Job>,
    checked: Checked,
    tiles: BTreeMap<u64, Reduced>,
) -> Result<Answer, Failure> {
    let broker = &coordinator.broker;
    let Checked { request, capture, design, requester, .. } = checked;
    let keeper = coordinator.journal.clone().zip(job.key);
    let prepared =
        prepare(&coordinator.captures, job.evaluation, requester, Asked { capture, design, request }, keeper).await?;
    let (active, outcome) = prepared;
    let mut restored = Vec::new();
    for (tile, reduced) in tiles {
        let tile = usize::try_from(tile).unwrap_or(usize::MAX);
        match active.reduction.restore(tile, reduced) {
            Ok(()) => restored.push(tile),
            // It is rendered again.
            Err(problem) => {
                tracing::warn!(evaluation = job.evaluation, problem, "a tile of the journal is not taken over");
            }
        }
    }
    let registration = broker.resume(Arc::clone(&active), &restored);
    let _ = job.active.set(Arc::clone(&active));
    outcome.await.map_err(Failure::of_farm)??;
    let progress = with_loss(broker.progress(job.evaluation), &active);
    drop(registration);
    let evaluation = tokio::task::spawn_blocking(move || active.reduction.finish()).await.map_err(Failure::of_farm)?;
    Ok(Answer { evaluation: evaluation.map_err(Failure::of_request)?, progress })
}
