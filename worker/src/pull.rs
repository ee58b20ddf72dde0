//! The pull loop: one stream to a coordinator, for as long as it lasts.

use crate::renderer::Scene;
use crate::scenes::SceneUnavailable;
use crate::{BlobSource, Worker};
use futures::StreamExt;
use futures::stream::BoxStream;
use gonio_proto::convert::film::film_to_wire;
use gonio_proto::convert::task::{AttemptId, Hello, Setup, Task};
use gonio_proto::wire::{self, from_worker, to_worker};
use gonio_proto::{Digest, WireError};
use gonio_tracer::TileTask;
use std::collections::{BTreeMap, BTreeSet};
use std::future::Future;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinSet;
use tonic::Status;

/// How long a worker that stops waits for the coordinator to hear that it does.
const FAREWELL: Duration = Duration::from_secs(2);

/// One stream to a coordinator.
pub struct Link {
    /// What the worker says. Bounded, so that a slow coordinator slows the worker down.
    pub outbound: mpsc::Sender<wire::FromWorker>,
    /// What it is told.
    pub inbound: BoxStream<'static, Result<wire::ToWorker, Status>>,
    /// Where it fetches captures' files.
    pub blobs: Arc<dyn BlobSource>,
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

/// An evaluation that the coordinator told of.
struct Known {
    setup: Arc<Setup>,
    scene_key: Digest,
    /// Set once, when the evaluation is over or the stream has ended.
    cancel: Arc<AtomicBool>,
}

/// A stream's state; dropped, everything that runs for it is cancelled.
struct Session<'w> {
    worker: &'w Worker,
    outbound: mpsc::Sender<wire::FromWorker>,
    blobs: Arc<dyn BlobSource>,
    evaluations: BTreeMap<u64, Known>,
    /// Attempts whose lease is this worker's.
    held: BTreeSet<AttemptId>,
    /// One per attempt held; yields its id when it has ended.
    running: JoinSet<AttemptId>,
}

impl Drop for Session<'_> {
    fn drop(&mut self) {
        for known in self.evaluations.values() {
            known.cancel.store(true, Ordering::Relaxed);
        }
    }
}

impl Worker {
    /// Works on one stream until it ends, or until `stop` completes: then the leases are handed back.
    ///
    /// # Errors
    /// The stream ended, or what came is not the protocol.
    pub async fn serve(&self, mut link: Link, stop: impl Future<Output = ()>) -> Result<(), PullError> {
        let hello = Hello { name: self.name.clone(), slots: self.slots(), version: gonio_proto::VERSION.to_owned() };
        let mut session = Session {
            worker: self,
            outbound: link.outbound,
            blobs: link.blobs,
            evaluations: BTreeMap::new(),
            held: BTreeSet::new(),
            running: JoinSet::new(),
        };
        session.send(from_worker::Message::Hello(hello.into())).await?;
        let lease = match next(&mut link.inbound).await? {
            to_worker::Message::Welcome(welcome) => Duration::from_millis(welcome.lease_milliseconds.max(3).into()),
            _ => return Err(WireError::new("ToWorker", "must begin with Welcome").into()),
        };
        // One task more than threads for each: the next one waits here when one ends, not at the coordinator.
        session.ask(2 * self.slots()).await?;
        let mut renew = tokio::time::interval(lease / 3);
        renew.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        tokio::pin!(stop);
        loop {
            tokio::select! {
                message = next(&mut link.inbound) => session.receive(message?)?,
                Some(ended) = session.running.join_next() => {
                    if let Ok(id) = ended {
                        session.held.remove(&id);
                    }
                }
                _ = renew.tick(), if !session.held.is_empty() => session.renew().await?,
                () = &mut stop => break,
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
        send(&self.outbound, message).await.map_err(PullError::Ended)
    }

    async fn ask(&self, tasks: u32) -> Result<(), PullError> {
        self.send(from_worker::Message::Ask(wire::Ask { tasks })).await
    }

    async fn renew(&self) -> Result<(), PullError> {
        let attempts = self.held.iter().map(|id| (*id).into()).collect();
        self.send(from_worker::Message::Renew(wire::Renew { attempts })).await
    }

    /// Stops everything and tells the coordinator, so that it need not wait for the leases to run out.
    async fn hand_back(&mut self) -> Result<(), PullError> {
        for known in self.evaluations.values() {
            known.cancel.store(true, Ordering::Relaxed);
        }
        for id in std::mem::take(&mut self.held) {
            let released = wire::Released { id: Some(id.into()), text: String::new() };
            self.send(from_worker::Message::Released(released)).await?;
        }
        Ok(())
    }

    fn receive(&mut self, message: to_worker::Message) -> Result<(), PullError> {
        match message {
            to_worker::Message::Welcome(_) => {
                return Err(WireError::new("ToWorker.welcome", "came a second time").into());
            }
            to_worker::Message::Setup(setup) => {
                let setup = Setup::try_from(setup)?;
                let (evaluation, scene_key) = (setup.evaluation, setup.scene_key());
                let known = Known { setup: Arc::new(setup), scene_key, cancel: Arc::default() };
                self.evaluations.insert(evaluation, known);
            }
            to_worker::Message::Task(task) => self.start(Task::try_from(task)?)?,
            to_worker::Message::Cancel(cancel) => {
                if let Some(known) = self.evaluations.remove(&cancel.evaluation) {
                    known.cancel.store(true, Ordering::Relaxed);
                }
            }
        }
        Ok(())
    }

    fn start(&mut self, task: Task) -> Result<(), PullError> {
        let Some(known) = self.evaluations.get(&task.id.evaluation) else {
            return Err(WireError::new("Task.id", format!("{}: no Setup came before it", task.id)).into());
        };
        let (setup, scene_key, cancel) = (Arc::clone(&known.setup), known.scene_key, Arc::clone(&known.cancel));
        let (worker, blobs, outbound) = (self.worker.clone(), Arc::clone(&self.blobs), self.outbound.clone());
        self.held.insert(task.id);
        self.running.spawn(async move {
            let id = task.id;
            let result = attempt(&worker, &setup, scene_key, task, &*blobs, cancel).await;
            // First the next task: its way here and this film's way there take their time together.
            let ask = wire::FromWorker { message: Some(from_worker::Message::Ask(wire::Ask { tasks: 1 })) };
            for message in std::iter::once(ask).chain(result) {
                // A stream that has ended is noticed where it is read.
                if outbound.send(message).await.is_err() {
                    break;
                }
            }
            id
        });
        Ok(())
    }
}

async fn send(outbound: &mpsc::Sender<wire::FromWorker>, message: from_worker::Message) -> Result<(), Status> {
    let message = wire::FromWorker { message: Some(message) };
    outbound.send(message).await.map_err(|_| Status::unavailable("end of stream"))
}

/// Renders one task; the messages that end the attempt, none if it was cancelled.
async fn attempt(
    worker: &Worker,
    setup: &Setup,
    scene_key: Digest,
    task: Task,
    blobs: &dyn BlobSource,
    cancel: Arc<AtomicBool>,
) -> Vec<wire::FromWorker> {
    let id = task.id;
    let scene = match worker.scenes.get(scene_key, setup, blobs).await {
        Ok(scene) => scene,
        Err(SceneUnavailable::Broken(text)) => return vec![failed(id, text)],
        Err(SceneUnavailable::NotFetched(text)) => {
            let released = wire::Released { id: Some(id.into()), text };
            return vec![wire::FromWorker { message: Some(from_worker::Message::Released(released)) }];
        }
    };
    let first_hits = setup.first_hits;
    let (sender, receiver) = oneshot::channel();
    worker.pool.spawn(move || {
        let rendered = catch_unwind(AssertUnwindSafe(|| render(&*scene, &task, first_hits, &cancel)));
        let text = || format!("rendering {id} of photo {} panicked", task.photo);
        // Whoever waited has gone with the stream.
        let _ = sender.send(rendered.unwrap_or_else(|_| vec![failed(id, text())]));
    });
    receiver.await.unwrap_or_default()
}

fn failed(id: AttemptId, text: String) -> wire::FromWorker {
    wire::FromWorker { message: Some(from_worker::Message::Failed(wire::TaskFailed { id: Some(id.into()), text })) }
}

/// Runs on a render thread.
fn render(scene: &dyn Scene, task: &Task, first_hits: bool, cancel: &AtomicBool) -> Vec<wire::FromWorker> {
    if cancel.load(Ordering::Relaxed) {
        return Vec::new();
    }
    let start = Instant::now();
    let tile = TileTask {
        photo: task.photo,
        tile: task.tile,
        pixels: &task.pixels,
        samples: task.samples.clone(),
        seed: task.seed,
        difference_samples: task.difference_samples,
    };
    let film = if first_hits { scene.first_hits(&tile, cancel) } else { scene.render(&tile, cancel) };
    match film {
        // Without a way out of the loop, so that it is a vector loop.
        Some(film) if film.data.iter().fold(true, |finite, value| finite & value.is_finite()) => {
            film_to_wire(task.id, &film, start.elapsed()).collect()
        }
        Some(_) => {
            let text = format!(
                "photo {}: the render overflows; lower the capture's radiances to the order of one",
                task.photo
            );
            vec![failed(task.id, text)]
        }
        None if cancel.load(Ordering::Relaxed) => Vec::new(),
        None => {
            vec![failed(task.id, format!("photo {}: cannot be rendered, the capture has no such photo", task.photo))]
        }
    }
}
