//! What one credit bought: tasks of one evaluation, which go through the queue together and come back one by one.

use crate::attempt::{self, Claim, failed, released, said};
use crate::scenes::SceneUnavailable;
use crate::{BlobSource, Worker};
use gonio_proto::Digest;
use gonio_proto::convert::task::{AttemptId, Setup, Task};
use gonio_proto::wire::{self, from_worker::Message};
use std::sync::Arc;
use tokio::sync::mpsc;

/// Tasks that are on this worker, and what they need.
pub(crate) struct Batch {
    pub setup: Arc<Setup>,
    pub scene_key: Digest,
    pub tasks: Vec<(Task, Arc<Claim>)>,
}

/// What a render thread says of an attempt.
enum Said {
    Started(AttemptId),
    /// The messages that end it.
    Ended(AttemptId, Vec<wire::FromWorker>),
}

impl Batch {
    /// Renders the tasks and says everything about them to `outbound`; each that has ended is named to `ended`. Asks for
    /// the next batch before it sends the last result: both take their time together.
    pub async fn run(
        self,
        worker: Worker,
        blobs: Arc<dyn BlobSource>,
        outbound: mpsc::Sender<wire::FromWorker>,
        ended: mpsc::UnboundedSender<AttemptId>,
    ) {
        let mut left = self.tasks.len();
        let mut results = self.begin(&worker, &*blobs).await;
        while let Some(said_of_it) = results.recv().await {
            let (id, messages) = match said_of_it {
                Said::Started(id) => (None, vec![said(Message::Started(wire::Started { id: Some(id.into()) }))]),
                Said::Ended(id, messages) => (Some(id), messages),
            };
            left -= usize::from(id.is_some());
            let ask = (id.is_some() && left == 0).then(|| said(Message::Ask(wire::Ask { credits: 1 })));
            for message in ask.into_iter().chain(messages) {
                // A stream that has ended is noticed where it is read.
                if outbound.send(message).await.is_err() {
                    return;
                }
            }
            // A session that has ended wants to know nothing.
            id.map(|id| ended.send(id));
        }
    }

    /// Puts the tasks into the queue, once there is a scene for them.
    async fn begin(self, worker: &Worker, blobs: &dyn BlobSource) -> mpsc::UnboundedReceiver<Said> {
        // Bounded by the tasks of the batch.
        let (sender, results) = mpsc::unbounded_channel();
        let scene = worker.scenes.get(self.scene_key, &self.setup, blobs).await;
        for (task, claim) in self.tasks {
            let (sender, id, first_hits) = (sender.clone(), task.id, self.setup.first_hits);
            // The other end has gone with the stream, if it has.
            match &scene {
                _ if claim.is_cancelled() => drop(sender.send(Said::Ended(id, Vec::new()))),
                Ok(scene) => {
                    let (scene, meter) = (Arc::clone(scene), Arc::clone(&worker.meter));
                    let setup = Arc::clone(&self.setup);
                    worker.queue.push(self.setup.class, move || {
                        if claim.is_cancelled() || !claim.take() {
                            let _ = sender.send(Said::Ended(id, Vec::new()));
                            return;
                        }
                        let _ = sender.send(Said::Started(id));
                        let span =
                            tracing::info_span!("task", task = id.task, attempt = id.attempt, photo = task.photo);
                        gonio_operations::follow(&span, &setup.trace_parent);
                        let _entered = span.enter();
                        let end = attempt::render(&*scene, &task, first_hits, &claim, &meter);
                        let _ = sender.send(Said::Ended(id, end));
                    });
                }
                Err(unavailable) => {
                    let end = match unavailable {
                        SceneUnavailable::Broken(text) => failed(id, text.clone()),
                        SceneUnavailable::NotFetched(text) => released(id, text.clone()),
                    };
                    let end = if claim.take() { vec![end] } else { Vec::new() };
                    let _ = sender.send(Said::Ended(id, end));
                }
            }
        }
        results
    }
}
