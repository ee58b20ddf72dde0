//! A worker that renders, and to whom things happen.

use crate::support::{SILENCE, film};
use crate::{Random, Reach};
use futures::StreamExt;
use gonio_coordinator::Coordinator;
use gonio_proto::convert::film::film_to_wire;
use gonio_proto::convert::task::{Task, tasks_from_wire};
use gonio_proto::wire::{self, from_worker, to_worker};
use std::time::Duration;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Status;

type Say = mpsc::Sender<Result<wire::FromWorker, Status>>;

/// Joins whichever coordinator there is, for ever.
pub async fn works(mut random: Random, mut reach: Reach) {
    loop {
        let coordinator = reach.borrow_and_update().clone();
        if let Some(coordinator) = coordinator {
            tokio::select! {
                () = serves(&mut random, &coordinator) => {}
                _ = reach.changed() => {}
            }
        }
        random.pause(Duration::from_secs(1)).await;
    }
}

async fn says(say: &Say, message: from_worker::Message) -> Option<()> {
    say.send(Ok(wire::FromWorker { message: Some(message) })).await.ok()
}

/// One stream, until it ends or the worker dies.
async fn serves(random: &mut Random, coordinator: &Coordinator) {
    let (say, receiver) = mpsc::channel(64);
    let mut hear = coordinator.work(ReceiverStream::new(receiver));
    let version = gonio_proto::VERSION.to_owned();
    let hello = wire::Hello { name: "simulated".into(), slots: 2, version, reserved_credits: 0 };
    if says(&say, from_worker::Message::Hello(hello)).await.is_none() {
        return;
    }
    let mut heart = tokio::task::JoinSet::new();
    while let Some(Ok(wire::ToWorker { message: Some(message) })) = hear.next().await {
        match message {
            to_worker::Message::Welcome(welcome) => {
                let (coordinator, id) = (coordinator.clone(), (welcome.worker, welcome.epoch));
                heart.spawn(async move {
                    while coordinator.beat(id.0, id.1).is_ok() {
                        tokio::time::sleep(SILENCE / 4).await;
                    }
                });
                let ask = wire::Ask { credits: 4 };
                if says(&say, from_worker::Message::Ask(ask)).await.is_none() {
                    return;
                }
            }
            to_worker::Message::Tasks(tasks) => {
                for task in tasks_from_wire(tasks).unwrap() {
                    if renders(random, &say, &task, &mut heart).await.is_none() {
                        return;
                    }
                }
            }
            _ => {}
        }
    }
}

/// Renders one task; none where the worker dies of it, or its stream has ended.
async fn renders(random: &mut Random, say: &Say, task: &Task, heart: &mut tokio::task::JoinSet<()>) -> Option<()> {
    says(say, from_worker::Message::Started(wire::Started { id: Some(task.id.into()) })).await?;
    random.pause(Duration::from_millis(400)).await;
    if random.chance(30) {
        return None;
    }
    if random.chance(30) {
        // Cut off from the network: it is taken for lost, and its results come too late.
        heart.abort_all();
        tokio::time::sleep(2 * SILENCE).await;
    }
    let times = if random.chance(50) { 2 } else { 1 };
    for _ in 0..times {
        let chunks: Vec<_> = film_to_wire(task.id, &film(task), Duration::from_millis(100)).collect();
        // A film may break off in the middle.
        let most = if random.chance(20) { chunks.len() / 2 } else { chunks.len() };
        let broken = most < chunks.len();
        for message in chunks.into_iter().take(most) {
            say.send(Ok(message)).await.ok()?;
        }
        if broken {
            return None;
        }
    }
    says(say, from_worker::Message::Ask(wire::Ask { credits: 1 })).await
}
