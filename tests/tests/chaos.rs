//! Real processes to which things happen at random moments: workers and the coordinator are killed, and paused so long that
//! they are taken for dead and come back. The answer has the bits of an undisturbed run, and comes.
//!
//! Two rounds; `GONIO_CHAOS=30 cargo test --release -p gonio-tests --test chaos` makes so many, each of its own seed.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

use gonio::farm::Farm;
use gonio_fit::evaluate::Evaluate;
use gonio_scene::{Capture, Evaluation, EvaluationRequest, Output};
use gonio_tests::cluster::{Cluster, files};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Longest that a round may take.
const PATIENCE: Duration = Duration::from_secs(180);
/// Evaluations of a round.
const EVALUATIONS: u64 = 3;

fn answer(farm: &Farm, seed: u64) -> Evaluation {
    let capture = Capture::read(&files()).unwrap();
    let columns = capture.free_parameters().unwrap();
    let output = Output::StatisticsAndFilms;
    let request =
        EvaluationRequest { columns, photos: vec![0, 3], samples: 260, seed, output, ..EvaluationRequest::default() };
    let begin = Instant::now();
    let answer = farm.open(&files()).unwrap().evaluate(&request, &mut |_| {
        // A farm that hangs would hang the test.
        if begin.elapsed() > PATIENCE { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    answer.unwrap()
}

/// Things that happen, until the round is over; how many.
fn happens(cluster: &mut Cluster, store: &Path, seed: u64, over: &AtomicBool) -> u32 {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut below = |most: u64| random.next_u64() % most;
    let mut count = 0;
    while !over.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(200 + below(1300)));
        let worker = below(cluster.workers.len() as u64) as usize;
        match below(4) {
            0 => {
                cluster.workers[worker].signal("KILL");
                drop(cluster.workers.remove(worker));
                cluster.add_worker();
            }
            1 => {
                // Longer than the silence after which it is taken for lost, or shorter.
                cluster.workers[worker].signal("STOP");
                std::thread::sleep(Duration::from_millis(below(6000)));
                cluster.workers[worker].signal("CONT");
            }
            2 => cluster.replace_coordinator(store),
            _ => {
                cluster.coordinator.signal("STOP");
                std::thread::sleep(Duration::from_millis(below(3000)));
                cluster.coordinator.signal("CONT");
            }
        }
        count += 1;
    }
    count
}

#[test]
fn whatever_happens_the_bits_are_the_same() {
    let rounds = std::env::var("GONIO_CHAOS").map_or(2, |text| text.parse().expect("GONIO_CHAOS: a whole number"));
    let quiet = Farm::embedded(2).unwrap();
    let expected: Vec<Evaluation> = (0..EVALUATIONS).map(|seed| answer(&quiet, seed)).collect();
    drop(quiet);
    for round in 0..rounds {
        let store = tempfile::tempdir().unwrap();
        let mut cluster = Cluster::durable(store.path(), 3);
        let farm = Farm::connect(&cluster.url).unwrap();
        let over = AtomicBool::new(false);
        let (begin, count) = (
            Instant::now(),
            std::thread::scope(|scope| {
                let chaos = scope.spawn(|| happens(&mut cluster, store.path(), round, &over));
                let same =
                    (0..EVALUATIONS).map(|seed| answer(&farm, seed) == expected[seed as usize]).collect::<Vec<_>>();
                over.store(true, Ordering::Relaxed);
                assert!(same.iter().all(|same| *same), "round {round}: other bits, {same:?}");
                chaos.join().unwrap()
            }),
        );
        println!("round {round}: {count} events in {:.1} s", begin.elapsed().as_secs_f64());
    }
}
