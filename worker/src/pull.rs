//! The pull loop: one stream to a coordinator, for as long as it lasts.

use crate::attempt::{Claim, released, said};
use crate::batch::Batch;
use crate::heart::{Heart, keep_beating};
use crate::{BlobSource, Meter, Worker};
use futures::StreamExt;
use futures::stream::BoxStream;
use gonio_proto::convert::task::{AttemptId, Hello, Setup, tasks_from_wire};
use gonio_proto::wire::{self, from_worker, to_worker};
use gonio_proto::{Digest, WireError};
use std::collections::BTreeMap;
use std::future::Future;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tonic::Status;

/// How long a worker that stops waits for the coordinator to hear that it does.
const FAREWELL: Duration = Duration::from_secs(2);

/// Credits for each render thread: one for what is rendered, one for what is next, one kept for interactive evaluations.
const CREDITS: u32 = 3;

/// One stream to a coordinator.
pub struct Link {
    /// What the worker says. Bounded, so that a slow coordinator slows the worker down.
    pub outbound: mpsc::Sender<wire::FromWorker>,
    /// What it is told.
    pub inbound: BoxStream<'static, Result<wire::ToWorker, Status>>,
    /// Where it fetches captures' files.
    pub blobs: Arc<dyn BlobSource>,
    /// How it says that it lives.
    pub heart: Arc<dyn Heart>,
}

/// Why a stream to a coordinator ended.
#[derive(Debug, thiserror::Error)]
pub enum PullError {
    /// The coordinator ended it, or the network did.
    #[error("the coordinator ended the stream: {0}")]
    Ended(Status),
    /// The coordinator sent something that this worker does not understand.
    #[error("the coordinator broke the protocol: {0}")]
    Protocol(#[from] WireError),
}

/// A stream's state; dropped, everything that runs for it is cancelled.
struct Session<'w> {
    worker: &'w Worker,
    outbound: mpsc::Sender<wire::FromWorker>,
    blobs: Arc<dyn BlobSource>,
    /// Evaluations that the coordinator told of and did not cancel, with the keys of their scenes.
    evaluations: BTreeMap<u64, (Arc<Setup>, Digest)>,
    /// Attempts on this worker. Added as they come; removed when they end, are handed back, revoked or cancelled.
    held: BTreeMap<AttemptId, Arc<Claim>>,
    /// Whether it hands everything back that comes.
    stopping: bool,
    /// One per batch that is here.
    batches: JoinSet<()>,
    /// Given to every batch, to name the attempts that have ended.
    ended: mpsc::UnboundedSender<AttemptId>,
}

/// Dropped, no coordinator has accepted the worker any more.
struct Accepted<'w>(&'w Meter);

impl Drop for Accepted<'_> {
    fn drop(&mut self) {
        self.0.accepted.store(false, Ordering::Relaxed);
    }
}

impl Drop for Session<'_> {
    fn drop(&mut self) {
        self.held.values().for_each(|claim| claim.cancel());
    }
}

impl Worker {
    /// Works on one stream until it ends, or until `stop` completes: then what waits is handed back, what is being
    /// rendered has the worker's grace to end, and what is left after it is handed back too.
    ///
    /// # Errors
    /// The stream ended, or what came is not the protocol.
    pub async fn serve(&self, mut link: Link, stop: impl Future<Output = ()>) -> Result<(), PullError> {
        let (slots, version) = (self.slots(), gonio_proto::VERSION.to_owned());
        let (ended, mut endings) = mpsc::unbounded_channel();
        let mut session = Session {
            worker: self,
            outbound: link.outbound,
            blobs: link.blobs,
            evaluations: BTreeMap::new(),
            held: BTreeMap::new(),
            stopping: false,
            batches: JoinSet::new(),
            ended,
        };
        let hello = Hello { name: self.name.clone(), slots, version, reserved_credits: slots };
        session.send(from_worker::Message::Hello(hello.into())).await?;
        let to_worker::Message::Welcome(welcome) = next(&mut link.inbound).await? else {
            return Err(WireError::new("ToWorker", "must begin with Welcome").into());
        };
        self.meter.accepted.store(true, Ordering::Relaxed);
        let _accepted = Accepted(&self.meter);
        // A task of its own: it beats while this one waits for a full channel. It ends with the set.
        let mut heart = JoinSet::new();
        let silence = Duration::from_millis(welcome.silence_milliseconds.into());
        heart.spawn(keep_beating(link.heart, welcome.worker, welcome.epoch, silence));
        session.send(from_worker::Message::Ask(wire::Ask { credits: CREDITS * slots })).await?;
        tokio::pin!(stop);
        let grace = tokio::time::sleep(Duration::ZERO);
        tokio::pin!(grace);
        loop {
            tokio::select! {
                message = next(&mut link.inbound) => session.receive(message?).await?,
                Some(id) = endings.recv() => drop(session.held.remove(&id)),
                // Batches that are done are forgotten; what they have to say, they have said.
                Some(_) = session.batches.join_next() => {}
                Some(forgotten) = heart.join_next() => {
                    let status = forgotten.unwrap_or_else(|error| Status::internal(error.to_string()));
                    return Err(PullError::Ended(Status::unavailable(status.message())));
                }
                () = &mut stop, if !session.stopping => {
                    self.meter.stopping.store(true, Ordering::Relaxed);
                    session.stop().await?;
                    grace.as_mut().reset(tokio::time::Instant::now() + self.grace);
                }
                () = &mut grace, if session.stopping => break,
            }
            if session.stopping && session.held.is_empty() {
                break;
            }
        }
        session.hand_back().await?;
        // The coordinator ends its side when ours has ended, and by then it has heard everything.
        drop(session);
        let drained = async { while link.inbound.next().await.is_some() {} };
        if tokio::time::timeout(FAREWELL, drained).await.is_err() {
            tracing::warn!("the coordinator did not end the stream in time");
        }
        Ok(())
    }
}

async fn next(
    inbound: &mut BoxStream<'static, Result<wire::ToWorker, Status>>,
) -> Result<to_worker::Message, PullError> {
    match inbound.next().await {
        Some(Ok(wire::ToWorker { message: Some(message) })) => Ok(message),
        Some(Ok(_)) => Err(WireError::new("ToWorker.message", "is absent or unknown here").into()),
        Some(Err(status)) => Err(PullError::Ended(status)),
        None => Err(PullError::Ended(Status::unavailable("end of stream"))),
    }
}

impl Session<'_> {
    async fn send(&self, message: from_worker::Message) -> Result<(), PullError> {
        self.say(said(message)).await
    }

    async fn say(&self, message: wire::FromWorker) -> Result<(), PullError> {
        let sent = self.outbound.send(message).await;
        sent.map_err(|_| PullError::Ended(Status::unavailable("end of stream")))
    }

    /// Wants no more tasks, and hands back those that no thread has begun.
    async fn stop(&mut self) -> Result<(), PullError> {
        self.stopping = true;
        self.send(from_worker::Message::Leaving(wire::Leaving {})).await?;
        let waiting: Vec<AttemptId> = self.held.iter().filter(|(_, claim)| claim.take()).map(|(id, _)| *id).collect();
        tracing::info!(handed_back = waiting.len(), to_finish = self.held.len() - waiting.len(), "stopping");
        for id in waiting {
            self.held.remove(&id);
            self.say(released(id, String::new())).await?;
        }
        Ok(())
    }

    /// Stops everything and tells the coordinator, so that it does not take it for a death.
    async fn hand_back(&mut self) -> Result<(), PullError> {
        for (id, claim) in std::mem::take(&mut self.held) {
            claim.cancel();
            self.say(released(id, String::new())).await?;
        }
        Ok(())
    }

    async fn receive(&mut self, message: to_worker::Message) -> Result<(), PullError> {
        match message {
            to_worker::Message::Welcome(_) => {
                return Err(WireError::new("ToWorker.welcome", "came a second time").into());
            }
            to_worker::Message::Setup(setup) => {
                let setup = Setup::try_from(setup)?;
                let scene_key = setup.scene_key();
                self.evaluations.insert(setup.evaluation, (Arc::new(setup), scene_key));
            }
            to_worker::Message::Tasks(tasks) => self.start(tasks).await?,
            to_worker::Message::Cancel(cancel) => {
                self.evaluations.remove(&cancel.evaluation);
                self.held.retain(|id, claim| {
                    if id.evaluation == cancel.evaluation {
                        claim.cancel();
                    }
                    id.evaluation != cancel.evaluation
                });
            }
            to_worker::Message::Revoked(revoked) => {
                for id in revoked.attempts {
                    let id = AttemptId::from_wire("Revoked.attempts", Some(id))?;
                    if let Some(claim) = self.held.remove(&id) {
                        claim.cancel();
                    }
                }
            }
        }
        Ok(())
    }

    async fn start(&mut self, tasks: wire::Tasks) -> Result<(), PullError> {
        let tasks = tasks_from_wire(tasks)?;
        if self.stopping {
            // They crossed with the word that this worker stops.
            for task in tasks {
                self.say(released(task.id, String::new())).await?;
            }
            return Ok(());
        }
        let evaluation = tasks[0].id.evaluation;
        if let Some(stray) = tasks.iter().find(|task| task.id.evaluation != evaluation) {
            return Err(WireError::new("Tasks.tasks", format!("{} is of another evaluation", stray.id)).into());
        }
        let Some((setup, scene_key)) = self.evaluations.get(&evaluation).cloned() else {
            return Err(WireError::new("Task.id", format!("{}: no Setup came before it", tasks[0].id)).into());
        };
        let tasks: Vec<_> = tasks.into_iter().map(|task| (task, Arc::<Claim>::default())).collect();
        self.held.extend(tasks.iter().map(|(task, claim)| (task.id, Arc::clone(claim))));
        let batch = Batch { setup, scene_key, tasks };
        let (worker, blobs) = (self.worker.clone(), Arc::clone(&self.blobs));
        self.batches.spawn(batch.run(worker, blobs, self.outbound.clone(), self.ended.clone()));
        Ok(())
    }
}
