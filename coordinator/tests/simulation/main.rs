//! A farm in virtual time, over many seeds: coordinators that die and are followed by others, workers that die, fall silent, are
//! cut off and say things twice, an object store that is slow, refuses, and refuses what it has done, clients that lose
//! their streams and come back. The coordinator, its journal and its broker are the real ones; rendering and the network are not.
//!
//! Every evaluation must end with the bits of an undisturbed run: a lost tile, or one that counts twice, changes them. And it
//! must end: an hour of virtual time is far more than all the pauses that the programs make.
//!
//! `GONIO_SIMULATIONS=200 cargo test --release -p gonio-coordinator --test simulation` runs so many seeds, 12 are run without.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

mod client;
mod store;
#[path = "../support/mod.rs"]
mod support;
mod worker;

use gonio_coordinator::Coordinator;
use gonio_coordinator::store::Blobs;
use object_store::memory::InMemory;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use store::{Faults, FaultyStore};
use support::{SILENCE, answer, bits, files, request};
use tokio::sync::watch;

/// The coordinator that can be reached, if there is one.
type Reach = watch::Receiver<Option<Coordinator>>;

/// An actor's random numbers.
struct Random(Xoshiro256PlusPlus);

impl Random {
    fn of(seed: u64, actor: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(1_000_003) ^ actor))
    }

    fn below(&mut self, most: u64) -> u64 {
        self.0.next_u64() % most
    }

    /// True so many times in a thousand.
    fn chance(&mut self, thousandths: u64) -> bool {
        self.below(1000) < thousandths
    }

    async fn pause(&mut self, most: Duration) {
        tokio::time::sleep(Duration::from_millis(self.below(most.as_millis() as u64 + 1))).await;
    }
}

/// The bits of evaluations of one to three chunks, undisturbed.
async fn undisturbed() -> Vec<Vec<u32>> {
    let mut expected = Vec::new();
    for chunks in 1..=3 {
        let coordinator = Coordinator::new(Blobs::in_memory(), SILENCE);
        let digest = support::store(&coordinator, &files()).await;
        let events = coordinator.evaluate(request(digest, chunks)).unwrap();
        let mut worker = support::Script::join(&coordinator, 64).await;
        for _ in 0..2 * chunks {
            let task = worker.task().await;
            worker.commits(&task).await;
        }
        expected.push(bits(&answer(events).await.unwrap()));
    }
    expected
}

/// Starts coordinators over one store, one after another, and kills them, until it is dropped.
async fn fate(seed: u64, objects: Arc<InMemory>, reach: watch::Sender<Option<Coordinator>>, deaths: Arc<AtomicU64>) {
    let mut random = Random::of(seed, 0);
    for life in 0.. {
        let faults = Arc::new(Faults::new(seed, life));
        let blobs =
            Blobs::over("simulated://", Arc::new(FaultyStore { inner: objects.clone(), faults: faults.clone() }));
        // A store that refuses ends the program, and whoever runs it starts it again.
        let Ok(coordinator) = Coordinator::durable(blobs, SILENCE).await else {
            tokio::time::sleep(Duration::from_millis(200)).await;
            continue;
        };
        reach.send_replace(Some(coordinator.clone()));
        // Later lives are longer, so that a slow evaluation ends at last.
        let span = Duration::from_millis((300 + random.below(3000)) * (1 + life / 8));
        tokio::select! {
            () = tokio::time::sleep(span) => {}
            _ = coordinator.lost() => {}
        }
        deaths.fetch_add(1, Ordering::Relaxed);
        // Dead: what it still has under way reaches neither the store nor anybody else.
        faults.die();
        reach.send_replace(None);
        random.pause(Duration::from_secs(8)).await;
        // Sometimes a standby takes over from one that only seemed dead.
        if random.chance(300) {
            faults.revive();
        }
    }
}

async fn simulate(seed: u64, expected: &[Vec<u32>]) -> u64 {
    let objects = Arc::new(InMemory::new());
    let quiet = Coordinator::new(Blobs::over("memory://", objects.clone()), SILENCE);
    let digest = support::store(&quiet, &files()).await;
    drop(quiet);
    let (sender, reach) = watch::channel(None);
    let deaths = Arc::new(AtomicU64::new(0));
    let mut others = tokio::task::JoinSet::new();
    others.spawn(fate(seed, objects, sender, deaths.clone()));
    for worker in 0..3 {
        others.spawn(worker::works(Random::of(seed, 100 + worker), reach.clone()));
    }
    let clients = (0..3).map(|client| client::asks(Random::of(seed, 200 + client), reach.clone(), digest, expected));
    let all = futures::future::join_all(clients);
    let done = tokio::time::timeout(Duration::from_secs(3600), all).await;
    assert!(done.is_ok(), "seed {seed}: hangs");
    others.shutdown().await;
    deaths.load(Ordering::Relaxed)
}

#[tokio::test(start_paused = true)]
async fn every_evaluation_ends_with_the_bits_of_an_undisturbed_run() {
    let text = std::env::var("GONIO_SIMULATIONS").unwrap_or_else(|_| "12".to_owned());
    let seeds: u64 = text.parse().expect("GONIO_SIMULATIONS: write a whole number");
    let expected = undisturbed().await;
    let mut deaths = 0;
    for seed in 0..seeds {
        deaths += simulate(seed, &expected).await;
    }
    println!("{seeds} seeds, {deaths} deaths of coordinators");
    // A farm that nothing befalls proves nothing.
    assert!(deaths > seeds);
}
