//! A client that asks for evaluations one after another, and comes back with the same key when its stream is cut.

use crate::support::{bits, request};
use crate::{Random, Reach};
use futures::StreamExt;
use gonio_coordinator::Coordinator;
use gonio_proto::convert::event::{Event, FilmCollector};
use gonio_proto::{Digest, Key, wire};
use std::time::Duration;

/// Evaluations of each client.
const EVALUATIONS: u64 = 8;

/// Asks, and compares every answer.
pub async fn asks(mut random: Random, mut reach: Reach, digest: Digest, expected: &[Vec<u32>]) {
    for _ in 0..EVALUATIONS {
        let chunks = 1 + random.below(expected.len() as u64) as u32;
        let fresh = || Key::fresh().unwrap().to_wire();
        let mut request =
            wire::EvaluationRequest { key: fresh(), client: "simulated".into(), ..request(digest, chunks) };
        let films = loop {
            let coordinator = reach.borrow_and_update().clone();
            if let Some(coordinator) = coordinator {
                // Sometimes the stream alone is cut.
                let patience = if random.chance(300) { random.below(1500) } else { u64::MAX >> 24 };
                tokio::select! {
                    end = once(&coordinator, request.clone()) => match end {
                        End::Films(films) => break films,
                        End::Cut => {}
                        End::SetAside => request.key = fresh(),
                    },
                    () = tokio::time::sleep(Duration::from_millis(patience)) => {}
                    _ = reach.changed() => {}
                }
            }
            random.pause(Duration::from_millis(700)).await;
        };
        assert!(films == expected[chunks as usize - 1], "{chunks} chunks: other bits than undisturbed");
        random.pause(Duration::from_secs(2)).await;
    }
}

/// How an attempt to hear an answer ends.
enum End {
    /// With its bits.
    Films(Vec<u32>),
    /// The coordinator has gone away first.
    Cut,
    /// By chance a task has killed so many workers that it is not tried again, and its client was told.
    SetAside,
}

async fn once(coordinator: &Coordinator, request: wire::EvaluationRequest) -> End {
    let Ok(mut events) = coordinator.evaluate(request) else { return End::Cut };
    let mut films = FilmCollector::default();
    while let Some(event) = events.next().await {
        match Event::try_from(event).unwrap() {
            Event::Film(chunk) => films.add(chunk).unwrap(),
            Event::Finished { .. } => return End::Films(bits(&films.finish().unwrap())),
            // A coordinator that stops says so; nothing else may fail here.
            Event::Failed { text, .. } => {
                if text.contains("is set aside") {
                    return End::SetAside;
                }
                assert!(text.contains("coordinator") || text.contains("store"), "{text}");
                return End::Cut;
            }
            _ => {}
        }
    }
    End::Cut
}
