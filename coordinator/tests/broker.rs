//! Leases and commits, seen by workers that misbehave in every way that time and networks have: the answer must have the
//! bits of an undisturbed run, and every task must be committed once. Time is tokio's, paused: it jumps to the next timer.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

mod support;

use futures::FutureExt;
use gonio_coordinator::broker::MOST_LOST_ATTEMPTS;
use gonio_proto::wire::{self, from_worker, to_worker};
use std::time::Duration;
use support::{LEASE, Script, answer, bits, coordinator, film, request};

/// The bits of an undisturbed run by one worker, in order.
async fn undisturbed(chunks: u32) -> Vec<u32> {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, chunks)).unwrap();
    let mut worker = Script::join(&coordinator, 2 * chunks).await;
    for _ in 0..2 * chunks {
        let task = worker.task().await;
        worker.commits(&task).await;
    }
    bits(&answer(events).await.unwrap())
}

#[tokio::test(start_paused = true)]
async fn no_order_of_arrival_shows_in_the_bits() {
    let expected = undisturbed(3).await;
    for order in [[5, 4, 3, 2, 1, 0], [3, 0, 5, 2, 1, 4], [1, 2, 0, 4, 5, 3]] {
        let (coordinator, digest) = coordinator().await;
        let events = coordinator.evaluate(request(digest, 3)).unwrap();
        let mut workers = [Script::join(&coordinator, 3).await, Script::join(&coordinator, 3).await];
        let mut tasks = Vec::new();
        for i in 0..6 {
            tasks.push((i % 2, workers[i % 2].task().await));
        }
        tasks.sort_by_key(|(_, task)| task.id.task);
        for (sent, i) in order.into_iter().enumerate() {
            workers[tasks[i].0].commits(&tasks[i].1).await;
            // The next film is not sent before this one is accepted.
            while coordinator.broker.counters().committed <= sent as u64 {
                tokio::task::yield_now().await;
            }
        }
        assert_eq!(bits(&answer(events).await.unwrap()), expected);
    }
}

#[tokio::test(start_paused = true)]
async fn an_expired_lease_is_handed_out_again_and_its_late_commit_refused() {
    let expected = undisturbed(1).await;
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    let mut paused = Script::join(&coordinator, 2).await;
    let (first, second) = (paused.task().await, paused.task().await);
    // A third of the lease later it renews one of the two, and then falls silent.
    tokio::time::sleep(LEASE / 3).await;
    paused.renews(&[&second]).await;
    let mut other = Script::join(&coordinator, 2).await;
    let again = other.task().await;
    assert_eq!((again.id.task, again.id.attempt), (first.id.task, 1));
    assert_eq!(coordinator.broker.counters().expired, 1);
    // Back again, it finishes both: one lease has gone, the renewed one holds.
    paused.commits(&first).await;
    paused.commits(&second).await;
    other.commits(&again).await;
    assert_eq!(bits(&answer(events).await.unwrap()), expected);
    let counters = coordinator.broker.counters();
    assert_eq!((counters.granted, counters.committed, counters.refused), (3, 2, 1));
}

#[tokio::test(start_paused = true)]
async fn a_commit_counts_once_and_only_for_who_holds_the_lease() {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    let mut honest = Script::join(&coordinator, 2).await;
    let (first, second) = (honest.task().await, honest.task().await);
    let thief = Script::join(&coordinator, 0).await;
    let lie = gonio_scene::film::TileFilm { data: vec![1e9; 2 * 3 * 1024], ..film(&first) };
    thief.sends(first.id, &lie).await;
    honest.sends(gonio_proto::convert::task::AttemptId { epoch: 1, ..first.id }, &lie).await;
    honest.sends(gonio_proto::convert::task::AttemptId { attempt: 7, ..first.id }, &lie).await;
    honest.sends(gonio_proto::convert::task::AttemptId { task: 99, ..first.id }, &lie).await;
    honest.commits(&first).await;
    honest.sends(first.id, &lie).await;
    // The lies have been heard before the last good film is sent.
    while coordinator.broker.counters().refused < 5 {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    honest.commits(&second).await;
    assert_eq!(bits(&answer(events).await.unwrap()), undisturbed(1).await);
    assert_eq!((coordinator.broker.counters().committed, coordinator.broker.counters().refused), (2, 5));
}

#[tokio::test(start_paused = true)]
async fn a_worker_that_goes_or_hands_back_loses_nothing() {
    let expected = undisturbed(2).await;
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 2)).unwrap();
    let mut gone = Script::join(&coordinator, 2).await;
    let done = gone.task().await;
    gone.commits(&done).await;
    gone.task().await;
    let mut polite = Script::join(&coordinator, 1).await;
    let task = polite.task().await;
    let released = wire::Released { id: Some(task.id.into()), text: String::new() };
    polite.says(from_worker::Message::Released(released)).await;
    while coordinator.broker.counters().committed == 0 {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    drop(gone);
    let mut last = Script::join(&coordinator, 3).await;
    for _ in 0..3 {
        let task = last.task().await;
        last.commits(&task).await;
    }
    assert_eq!(bits(&answer(events).await.unwrap()), expected);
    let counters = coordinator.broker.counters();
    assert_eq!((counters.returned, counters.committed, counters.workers_gone), (2, 4, 1));
}

#[tokio::test(start_paused = true)]
async fn a_task_that_is_lost_again_and_again_ends_its_evaluation() {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    for _ in 0..MOST_LOST_ATTEMPTS {
        let mut victim = Script::join(&coordinator, 1).await;
        assert_eq!(victim.task().await.id.task, 0);
    }
    let text = answer(events).await.unwrap_err();
    assert!(text.contains("task 0 (photo 0, tile at 0, 0, chunk 0) was lost 16 times"), "{text}");
}

#[tokio::test(start_paused = true)]
async fn a_failed_task_ends_its_evaluation_with_its_text() {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    let mut worker = Script::join(&coordinator, 1).await;
    let id = worker.task().await.id;
    let text = "part.ply: face 7: has no area\x1b[2J; remove it".to_owned();
    worker.says(from_worker::Message::Failed(wire::TaskFailed { id: Some(id.into()), text })).await;
    assert_eq!(answer(events).await.unwrap_err(), "part.ply: face 7: has no area [2J; remove it");
    assert!(matches!(worker.hears().await, to_worker::Message::Cancel(_)));
}

#[tokio::test(start_paused = true)]
async fn dropping_the_stream_cancels_and_frees_the_workers() {
    let (coordinator, digest) = coordinator().await;
    let first = coordinator.evaluate(request(digest, 1)).unwrap();
    let mut worker = Script::join(&coordinator, 1).await;
    let old = worker.task().await;
    drop(first);
    let cancel = worker.hears().await;
    assert!(matches!(cancel, to_worker::Message::Cancel(c) if c.evaluation == old.id.evaluation));
    // What it still sends of the old evaluation is passed over; the new one is served.
    worker.commits(&old).await;
    let second = coordinator.evaluate(request(digest, 1)).unwrap();
    worker.asks(2).await;
    for _ in 0..2 {
        let task = worker.task().await;
        worker.commits(&task).await;
    }
    assert_eq!(bits(&answer(second).await.unwrap()), undisturbed(1).await);
    assert_eq!(coordinator.broker.counters().refused, 1);
}

#[tokio::test(start_paused = true)]
async fn evaluations_and_workers_take_turns() {
    let (coordinator, digest) = coordinator().await;
    let (_a, _b) =
        (coordinator.evaluate(request(digest, 9)).unwrap(), coordinator.evaluate(request(digest, 9)).unwrap());
    // Both are split before anybody asks.
    tokio::time::sleep(Duration::from_secs(1)).await;
    let mut worker = Script::join(&coordinator, 4).await;
    let mut evaluations = Vec::new();
    for _ in 0..4 {
        evaluations.push(worker.task().await.id.evaluation);
    }
    assert!(evaluations[0] != evaluations[1] && evaluations[..2] == evaluations[2..], "{evaluations:?}");
}

#[tokio::test(start_paused = true)]
async fn idle_workers_share_a_new_evaluation() {
    let (coordinator, digest) = coordinator().await;
    let mut idle = [Script::join(&coordinator, 16).await, Script::join(&coordinator, 16).await];
    let _events = coordinator.evaluate(request(digest, 1)).unwrap();
    for worker in &mut idle {
        worker.task().await;
    }
}

#[tokio::test(start_paused = true)]
async fn an_evaluation_without_workers_waits_and_says_so() {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    tokio::time::sleep(Duration::from_secs(3600)).await;
    let mut answer = Box::pin(answer(events));
    assert!(answer.as_mut().now_or_never().is_none());
    let mut worker = Script::join(&coordinator, 2).await;
    for _ in 0..2 {
        let task = worker.task().await;
        worker.commits(&task).await;
    }
    answer.await.unwrap();
}
