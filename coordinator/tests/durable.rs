//! Evaluations that outlive their clients' streams and their coordinator: what an earlier coordinator has reduced is not
//! rendered again, the answer has the bits of an undisturbed run, and whoever lost the farm writes nothing any more.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

mod support;

use gonio_coordinator::Coordinator;
use gonio_coordinator::jobs::LINGER;
use gonio_coordinator::store::Blobs;
use gonio_proto::convert::event::CANCELLED;
use gonio_proto::{Digest, Key, wire};
use std::time::Duration;
use support::{SILENCE, Script, answer, bits, files, request, store};
use tonic::Code;

/// A coordinator that owns the farm of a store, which holds a capture of two tiles.
async fn durable(blobs: &Blobs) -> (Coordinator, Digest) {
    let coordinator = Coordinator::durable(blobs.clone(), SILENCE).await.unwrap();
    let digest = store(&coordinator, &files()).await;
    (coordinator, digest)
}

fn keyed(digest: Digest, chunks: u32, key: Key) -> wire::EvaluationRequest {
    wire::EvaluationRequest { key: key.to_wire(), client: "test".into(), ..request(digest, chunks) }
}

/// The bits of an undisturbed run.
async fn undisturbed(chunks: u32) -> Vec<u32> {
    let (coordinator, digest) = durable(&Blobs::in_memory()).await;
    let events = coordinator.evaluate(request(digest, chunks)).unwrap();
    let mut worker = Script::join(&coordinator, 64).await;
    works(&mut worker, 2 * chunks).await;
    bits(&answer(events).await.unwrap())
}

/// Renders the next tasks.
async fn works(worker: &mut Script, tasks: u32) {
    for _ in 0..tasks {
        let task = worker.task().await;
        worker.commits(&task).await;
    }
}

async fn until(mut done: impl AsyncFnMut() -> bool) {
    let wait = async {
        while !done().await {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(60), wait).await.expect("it never came to that");
}

/// Segments of the journal.
async fn segments(blobs: &Blobs) -> usize {
    blobs.log("journal").numbers().await.unwrap().len()
}

#[tokio::test(start_paused = true)]
async fn the_next_coordinator_goes_on_and_renders_only_what_was_not_complete() {
    let expected = undisturbed(3).await;
    let blobs = Blobs::in_memory();
    let (first, digest) = durable(&blobs).await;
    let key = Key::fresh().unwrap();
    let lost_stream = first.evaluate(keyed(digest, 3, key)).unwrap();
    let mut worker = Script::join(&first, 64).await;
    works(&mut worker, 4).await;
    // The request, and the tile that is complete: the fourth task's is not.
    until(async || segments(&blobs).await == 2).await;
    until(async || first.broker.counters().committed == 4).await;

    let second = Coordinator::durable(blobs.clone(), SILENCE).await.unwrap();
    assert!(second.broker.epoch() > first.broker.epoch());
    let events = second.evaluate(keyed(digest, 3, key)).unwrap();
    let mut other = Script::join(&second, 64).await;
    works(&mut other, 3).await;
    assert_eq!(bits(&answer(events).await.unwrap()), expected);
    assert_eq!(second.broker.counters().committed, 3);

    // The former owner renders on, unaware, until it writes: then it knows.
    works(&mut worker, 2).await;
    let why = first.lost().await;
    assert!(why.contains("another coordinator"), "{why}");
    first.drain(Duration::from_secs(10)).await;
    drop(lost_stream);
    // The evaluation is over, and with it all that was written of it.
    until(async || segments(&blobs).await == 1).await;
}

#[tokio::test(start_paused = true)]
async fn what_was_complete_is_not_rendered_at_all() {
    let expected = undisturbed(1).await;
    let blobs = Blobs::in_memory();
    let (first, digest) = durable(&blobs).await;
    let key = Key::fresh().unwrap();
    let events = first.evaluate(keyed(digest, 1, key)).unwrap();
    let mut worker = Script::join(&first, 64).await;
    works(&mut worker, 2).await;
    until(async || first.broker.counters().committed == 2).await;
    tokio::time::sleep(Duration::from_secs(1)).await;
    // Nobody has read the answer, so the evaluation is not over.
    let second = Coordinator::durable(blobs.clone(), SILENCE).await.unwrap();
    drop(events);
    let events = second.evaluate(keyed(digest, 1, key)).unwrap();
    assert_eq!(bits(&answer(events).await.unwrap()), expected);
    assert_eq!(second.broker.counters().granted, 0);
}

#[tokio::test(start_paused = true)]
async fn who_comes_back_with_the_key_hears_the_rest() {
    let expected = undisturbed(2).await;
    let (coordinator, digest) = durable(&Blobs::in_memory()).await;
    let key = Key::fresh().unwrap();
    drop(coordinator.evaluate(keyed(digest, 2, key)).unwrap());
    let mut worker = Script::join(&coordinator, 64).await;
    works(&mut worker, 2).await;
    tokio::time::sleep(LINGER - Duration::from_secs(1)).await;
    // Two listen now; each hears all of it.
    let (one, two) =
        (coordinator.evaluate(keyed(digest, 2, key)).unwrap(), coordinator.evaluate(keyed(digest, 2, key)).unwrap());
    works(&mut worker, 2).await;
    let (one, two) = tokio::join!(answer(one), answer(two));
    assert_eq!((bits(&one.unwrap()), bits(&two.unwrap())), (expected.clone(), expected));
    assert_eq!(coordinator.broker.counters().committed, 4);
}

#[tokio::test(start_paused = true)]
async fn what_nobody_comes_back_for_ends() {
    let blobs = Blobs::in_memory();
    let (coordinator, digest) = durable(&blobs).await;
    drop(coordinator.evaluate(keyed(digest, 2, Key::fresh().unwrap())).unwrap());
    tokio::time::sleep(LINGER + Duration::from_secs(1)).await;
    assert_eq!(coordinator.list().jobs.len(), 0);
    until(async || segments(&blobs).await == 1).await;
    // Nor does the next coordinator take it over for ever.
    drop(coordinator.evaluate(keyed(digest, 2, Key::fresh().unwrap())).unwrap());
    tokio::time::sleep(Duration::from_secs(1)).await;
    let second = Coordinator::durable(blobs.clone(), SILENCE).await.unwrap();
    assert_eq!(second.list().jobs.len(), 1);
    tokio::time::sleep(LINGER + Duration::from_secs(1)).await;
    assert_eq!(second.list().jobs.len(), 0);
}

#[tokio::test(start_paused = true)]
async fn a_key_is_one_evaluations_and_has_16_bytes() {
    let (coordinator, digest) = durable(&Blobs::in_memory()).await;
    let key = Key::fresh().unwrap();
    let _events = coordinator.evaluate(keyed(digest, 2, key)).unwrap();
    let refused = coordinator.evaluate(keyed(digest, 3, key)).unwrap_err();
    assert!(refused.message().contains("is that of another evaluation"), "{refused}");
    let short = wire::EvaluationRequest { key: vec![1, 2].into(), ..request(digest, 1) };
    assert_eq!(coordinator.evaluate(short).unwrap_err().code(), Code::InvalidArgument);
}

#[tokio::test(start_paused = true)]
async fn jobs_are_listed_and_cancelled_by_client() {
    let (coordinator, digest) = durable(&Blobs::in_memory()).await;
    let events = coordinator.evaluate(keyed(digest, 2, Key::fresh().unwrap())).unwrap();
    let other = wire::EvaluationRequest { client: "other".into(), ..request(digest, 1) };
    let _other = coordinator.evaluate(other).unwrap();
    let mut worker = Script::join(&coordinator, 64).await;
    works(&mut worker, 1).await;
    let done = |job: &wire::Job| job.progress.unwrap_or_default().tasks_done;
    until(async || coordinator.list().jobs.iter().map(done).sum::<u64>() == 1).await;
    let list = coordinator.list();
    let clients: Vec<_> = list.jobs.iter().map(|job| (job.client.as_str(), job.listeners)).collect();
    assert_eq!((clients, list.workers), (vec![("test", 1), ("other", 1)], 1));
    let cancel =
        |client: &str| coordinator.cancel(&wire::CancelRequest { client: client.into(), ..Default::default() });
    assert_eq!((cancel("nobody").unwrap(), cancel("test").unwrap()), (0, 1));
    assert_eq!(answer(events).await.unwrap_err(), CANCELLED);
    until(async || coordinator.list().jobs.len() == 1).await;
    assert_eq!(cancel("").unwrap_err().code(), Code::InvalidArgument);
}

#[tokio::test(start_paused = true)]
async fn a_standby_waits_while_the_owner_lives() {
    let blobs = Blobs::in_memory();
    let (owner, _) = durable(&blobs).await;
    let wait = gonio_coordinator::journal::wait_for_silence(&blobs);
    assert!(tokio::time::timeout(Duration::from_secs(3600), wait).await.is_err());
    // An owner that stops says so.
    owner.drain(Duration::ZERO).await;
    let wait = gonio_coordinator::journal::wait_for_silence(&blobs);
    tokio::time::timeout(Duration::from_secs(1), wait).await.unwrap();
}
