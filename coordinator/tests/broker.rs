//! Leases and commits, seen by workers that misbehave in every way that time and networks have: the answer must have the
//! bits of an undisturbed run, and every task must be committed once. Time is tokio's, paused: it jumps to the next timer.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

mod support;

use futures::FutureExt;
use gonio_coordinator::broker::loss::MOST_DEATHS;
use gonio_proto::convert::request::{Class, Requester};
use gonio_proto::wire::{self, from_worker, to_worker};
use std::time::Duration;
use support::{Script, answer, bits, coordinator, film, request};
use tokio::time::Instant;
use tonic::Code;

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
async fn a_silent_workers_leases_end_within_5_s_and_its_late_commit_is_refused() {
    let expected = undisturbed(1).await;
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    let mut paused = Script::join(&coordinator, 2).await;
    let (first, second) = (paused.task().await, paused.task().await);
    // It says nothing for an hour, but beats: whatever it may be doing, its leases hold.
    tokio::time::sleep(Duration::from_secs(3600)).await;
    assert_eq!(coordinator.broker.counters().returned, 0);
    paused.falls_silent();
    let silent = Instant::now();
    let mut other = Script::join(&coordinator, 2).await;
    // A straggler's second attempt would come before: this is about the first one's end.
    while coordinator.broker.counters().silences == 0 {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert!(silent.elapsed() < Duration::from_secs(5), "{:?}", silent.elapsed());
    // Back again, it sends both, and it was too late.
    paused.beats(&coordinator);
    paused.commits(&first).await;
    paused.commits(&second).await;
    while coordinator.broker.counters().refused < 2 {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    for _ in 0..2 {
        let again = other.task().await;
        assert!(again.id.attempt > 0);
        other.commits(&again).await;
    }
    assert_eq!(bits(&answer(events).await.unwrap()), expected);
    let counters = coordinator.broker.counters();
    assert_eq!((counters.committed, counters.refused, counters.workers_gone), (2, 2, 0));
    // And with the next credit it works again.
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    paused.asks(2).await;
    while !matches!(paused.hears().await, to_worker::Message::Cancel(_)) {}
    for _ in 0..2 {
        let task = paused.task().await;
        paused.commits(&task).await;
    }
    assert_eq!(bits(&answer(events).await.unwrap()), expected);
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
    let counters = coordinator.broker.counters();
    // The thief's, and that of another coordinator.
    assert_eq!((counters.committed, counters.refused, counters.foreign), (2, 5, 2));
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
async fn a_task_that_kills_its_workers_is_set_aside_and_one_that_waited_there_is_not() {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    for death in 0..MOST_DEATHS {
        let mut victim = Script::join(&coordinator, 2).await;
        let (rendered, waited) = (victim.task().await, victim.task().await);
        assert_eq!((rendered.id.task, waited.id.task), (0, 1));
        assert_eq!((rendered.id.attempt, waited.id.attempt), (death, death));
        victim.starts(&rendered).await;
        victim.dies().await;
    }
    let text = answer(events).await.unwrap_err();
    let expected = "task 0 (photo 0, tile at 0, 0, chunk 0) is set aside: 3 workers died while they rendered it";
    assert!(text.starts_with(expected), "{text}");
    assert_eq!(coordinator.broker.counters().set_aside, 1);
}

#[tokio::test(start_paused = true)]
async fn machines_may_be_lost_as_often_as_they_are() {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    for round in 0..20 {
        let mut lost = Script::join(&coordinator, 2).await;
        let (first, _) = (lost.task().await, lost.task().await);
        if round < 10 {
            // Its machine goes while it renders: no end of its stream is seen before the silence.
            lost.starts(&first).await;
            lost.falls_silent();
            while coordinator.broker.counters().silences <= round {
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
        }
        lost.dies().await;
    }
    let mut last = Script::join(&coordinator, 2).await;
    for _ in 0..2 {
        let task = last.task().await;
        last.commits(&task).await;
    }
    assert_eq!(bits(&answer(events).await.unwrap()), undisturbed(1).await);
    assert_eq!(coordinator.broker.counters().returned, 40);
}

#[tokio::test(start_paused = true)]
async fn a_straggler_is_tried_twice_and_the_first_commit_wins() {
    let expected = undisturbed(1).await;
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    let mut slow = Script::join(&coordinator, 1).await;
    let straggler = slow.task().await;
    let mut quick = Script::join(&coordinator, 2).await;
    let task = quick.task().await;
    quick.commits(&task).await;
    // Nothing else waits, and it has a credit left.
    let second = quick.task().await;
    assert_eq!((second.id.task, second.id.attempt), (straggler.id.task, straggler.id.attempt + 1));
    quick.commits(&second).await;
    assert_eq!(bits(&answer(events).await.unwrap()), expected);
    let revoked = slow.hears().await;
    let id: wire::AttemptId = straggler.id.into();
    assert!(matches!(&revoked, to_worker::Message::Revoked(r) if r.attempts == [id]), "{revoked:?}");
    slow.commits(&straggler).await;
    while coordinator.broker.counters().refused == 0 {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    let counters = coordinator.broker.counters();
    assert_eq!((counters.granted, counters.second, counters.committed, counters.revoked), (3, 1, 2, 1));
}

#[tokio::test(start_paused = true)]
async fn a_credit_buys_a_third_of_a_second_of_tasks() {
    let (coordinator, digest) = coordinator().await;
    let _events = coordinator.evaluate(request(digest, 9)).unwrap();
    let mut worker = Script::join(&coordinator, 1).await;
    let first = worker.tasks().await;
    assert_eq!(first.len(), 1, "nothing is known of its speed");
    worker.commits_slowly(&first[0]).await;
    while coordinator.broker.counters().committed == 0 {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    worker.asks(1).await;
    assert_eq!(worker.tasks().await.len(), 3, "of 0.1 s each");
    for _ in 0..10 {
        worker.asks(1).await;
    }
    let mut rest = Vec::new();
    while rest.iter().sum::<usize>() < 14 {
        rest.push(worker.tasks().await.len());
    }
    assert_eq!(rest, [3, 2, 2, 1, 1, 1, 1, 1, 1, 1], "less at the end, so that all end together");
}

#[tokio::test(start_paused = true)]
async fn a_sweep_leaves_room_for_a_fit() {
    let (coordinator, digest) = coordinator().await;
    let ask = |client: &str, class| {
        let mut message = request(digest, 9);
        Requester { client: client.to_owned(), class }.sign(&mut message);
        coordinator.evaluate(message).unwrap()
    };
    let _sweep: Vec<_> = (0..5).map(|_| ask("sweep", Class::Batch)).collect();
    tokio::time::sleep(Duration::from_secs(1)).await;
    let mut worker = Script::join_with(&coordinator, 3, 1).await;
    let sweeps = [worker.task().await, worker.task().await].map(|task| task.id.evaluation);
    assert_eq!(sweeps[0], sweeps[1], "the oldest first");
    assert!(worker.hears_nothing(), "the last credit is kept");
    let _fit = ask("fit", Class::Interactive);
    let fit = worker.task().await.id.evaluation;
    assert!(!sweeps.contains(&fit));
    // With credits for all, four of five go to the fit, although the sweep has five evaluations under way.
    worker.asks(20).await;
    let mut fits = 0;
    for _ in 0..15 {
        fits += usize::from(worker.task().await.id.evaluation == fit);
    }
    assert!((11..=13).contains(&fits), "{fits}");
}

#[tokio::test(start_paused = true)]
async fn a_worker_that_leaves_gets_nothing_more() {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    let mut leaving = Script::join(&coordinator, 1).await;
    let task = leaving.task().await;
    leaving.says(from_worker::Message::Leaving(wire::Leaving {})).await;
    leaving.asks(5).await;
    leaving.commits(&task).await;
    while coordinator.broker.counters().committed == 0 {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    assert!(leaving.hears_nothing());
    let mut other = Script::join(&coordinator, 1).await;
    let task = other.task().await;
    other.commits(&task).await;
    answer(events).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_coordinator_that_drains_finishes_what_runs_and_takes_nothing_new() {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    let mut worker = Script::join(&coordinator, 2).await;
    let tasks = [worker.task().await, worker.task().await];
    let drain = tokio::spawn({
        let coordinator = coordinator.clone();
        async move { coordinator.drain(Duration::from_secs(60)).await }
    });
    tokio::time::sleep(Duration::from_secs(1)).await;
    let refused = coordinator.evaluate(request(digest, 1)).unwrap_err();
    assert!(refused.code() == Code::Unavailable && refused.message().contains("stops"), "{refused:?}");
    for task in &tasks {
        worker.commits(task).await;
    }
    assert_eq!(bits(&answer(events).await.unwrap()), undisturbed(1).await);
    drain.await.unwrap();
    assert_eq!(worker.refusal().await.code(), Code::Unavailable);
}

#[tokio::test(start_paused = true)]
async fn a_coordinator_that_drains_ends_what_does_not_finish_in_time() {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    let start = Instant::now();
    let (answer, ()) = tokio::join!(answer(events), coordinator.drain(Duration::from_secs(60)));
    assert_eq!(answer.unwrap_err(), "the coordinator stops; ask again when it, or another, is up");
    assert!((60..62).contains(&start.elapsed().as_secs()), "{:?}", start.elapsed());
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
