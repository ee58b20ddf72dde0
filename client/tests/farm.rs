//! The farm from a client's request to its answer: real client, coordinator and worker, with a renderer that only pretends.
//! What must hold: equal bits whatever the transport, the threads and the losses; every failure ends in one clear error.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

mod support;

use gonio::farm::Farm;
use gonio_coordinator::store::Blobs;
use gonio_coordinator::{Coordinator, service};
use gonio_fit::evaluate::{Evaluate, EvaluateError};
use gonio_scene::{Evaluation, EvaluationRequest, Output, Progress};
use gonio_worker::Worker;
use gonio_worker::access::Access;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use support::{Fake, FakeRenderer, HEIGHT, WIDTH, capture, request};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Runtime;

const OUTPUTS: [Output; 4] = [Output::Statistics, Output::StatisticsAndFilms, Output::Films, Output::FirstHit];

fn embedded(threads: usize, fake: Fake) -> (Farm, Arc<Fake>) {
    let fake = Arc::new(fake);
    (Farm::embedded_with(threads, Arc::new(FakeRenderer(Arc::clone(&fake)))).unwrap(), fake)
}

fn evaluate(farm: &Farm, photos: usize, request: &EvaluationRequest) -> Result<Evaluation, EvaluateError> {
    farm.open(&capture(photos)).unwrap().evaluate(request, &mut |_| ControlFlow::Continue(()))
}

/// Every bit of an answer, for comparison.
fn bits(evaluation: &Evaluation) -> Vec<u64> {
    let mut bits = vec![evaluation.primary_samples];
    for s in &evaluation.photos {
        bits.extend([s.photo as u64, s.observations, s.invalid_samples]);
        let sums = [s.loss_variance(), s.noise_floor, s.render_noise, s.squared_error, s.log_variance, s.peak];
        bits.extend(s.gram.iter().chain(&s.noise).chain(&sums).map(|v| v.to_bits()));
    }
    let values = evaluation.films.iter().flat_map(|f| &f.channels).flatten();
    bits.extend(values.map(|v| u64::from(v.to_bits())));
    bits
}

#[test]
fn an_embedded_evaluation_answers_what_was_asked() {
    let (farm, fake) = embedded(2, Fake::default());
    for output in OUTPUTS {
        let answer = evaluate(&farm, 3, &request(&capture(3), 300, output)).unwrap();
        assert_eq!(answer.photos.len(), if output.compares() { 3 } else { 0 });
        assert_eq!(answer.films.len(), if output.has_films() { 3 } else { 0 });
        for s in &answer.photos {
            // Two tiles by three, three chunks each; every pixel counts.
            assert_eq!((s.observations, s.invalid_samples), (u64::from(3 * WIDTH * HEIGHT), 18));
            assert_eq!(s.gram.len(), 25);
            // Column 4 is photo 0's gain; it has no derivative in other photos.
            assert_eq!(s.gram[24] > 0.0, s.photo == 0);
            // The fake's halves agree with the photograph, up to noise that the debiased loss does not contain.
            assert!(s.loss().abs() < 0.2 * s.render_noise, "{} of {}", s.loss(), s.render_noise);
        }
        for film in &answer.films {
            assert_eq!((film.width, film.height), (WIDTH, HEIGHT));
            assert_eq!(film.channels.len(), if output == Output::FirstHit { 10 } else { 3 });
            assert!(film.channels.iter().flatten().all(|v| (0.4..0.6).contains(v)));
        }
        let rays = if output == Output::FirstHit { 1 } else { 300 };
        assert_eq!(answer.primary_samples, rays * u64::from(3 * WIDTH * HEIGHT));
    }
    assert_eq!(fake.loaded.load(Ordering::Relaxed), 1, "one capture is loaded once");
    assert_eq!(fake.prepared.load(Ordering::Relaxed), 2, "a scene with columns and one without");
}

#[test]
fn statistics_have_the_same_bits_with_and_without_films() {
    let (farm, _) = embedded(2, Fake::default());
    let alone = evaluate(&farm, 2, &request(&capture(2), 4, Output::Statistics)).unwrap();
    let mut along = evaluate(&farm, 2, &request(&capture(2), 4, Output::StatisticsAndFilms)).unwrap();
    along.films.clear();
    assert_eq!(bits(&alone), bits(&along));
}

/// A coordinator and workers behind TCP, inside this process.
struct Cluster {
    runtime: Runtime,
    url: String,
    coordinator: Coordinator,
}

impl Cluster {
    fn new() -> Self {
        // Whoever is lost here closes its connection; a paused test must not take anybody for silent.
        Self::with_silence(Duration::from_secs(3600))
    }

    fn with_silence(silence: Duration) -> Self {
        let runtime = Runtime::new().unwrap();
        let (url, coordinator) = runtime.block_on(async {
            let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
            let url = format!("http://{}", listener.local_addr().unwrap());
            let coordinator = Coordinator::new(Blobs::in_memory(), silence);
            tokio::spawn(service::serve(coordinator.clone(), listener, std::future::pending(), Duration::ZERO));
            (url, coordinator)
        });
        Self { runtime, url, coordinator }
    }

    fn worker(&self, threads: usize, fake: Fake) -> tokio::task::JoinHandle<()> {
        let worker = Worker::new("test", threads, Arc::new(FakeRenderer(Arc::new(fake)))).unwrap();
        self.worker_by(&self.url, worker)
    }

    fn worker_by(&self, url: &str, worker: Worker) -> tokio::task::JoinHandle<()> {
        let url = url.to_owned();
        self.runtime
            .spawn(async move { worker.work_for(&url, &Access::default(), std::future::pending()).await.unwrap() })
    }
}

#[test]
fn threads_transport_and_a_lost_worker_leave_no_trace_in_the_bits() {
    let slow = || Fake { delay: Duration::from_millis(3), ..Fake::default() };
    for output in OUTPUTS {
        let request = request(&capture(2), 300, output);
        let expected = bits(&evaluate(&embedded(1, Fake::default()).0, 2, &request).unwrap());
        assert_eq!(bits(&evaluate(&embedded(4, Fake::default()).0, 2, &request).unwrap()), expected);

        let cluster = Cluster::new();
        let (doomed, _) = (cluster.worker(2, slow()), cluster.worker(1, slow()));
        let farm = Farm::connect(&cluster.url).unwrap();
        let mut open = farm.open(&capture(2)).unwrap();
        let mut watch = |progress: &Progress| {
            if progress.tasks_done > 0 {
                doomed.abort();
            }
            ControlFlow::Continue(())
        };
        assert_eq!(bits(&open.evaluate(&request, &mut watch).unwrap()), expected);
        // Again, from what the farm has by now.
        assert_eq!(bits(&open.evaluate(&request, &mut watch).unwrap()), expected);
    }
}

#[test]
fn a_lost_workers_tasks_are_handed_out_again() {
    let cluster = Cluster::new();
    let stuck = cluster.worker(2, Fake { delay: Duration::from_secs(1000), ..Fake::default() });
    let farm = Farm::connect(&cluster.url).unwrap();
    let request = request(&capture(1), 2, Output::Films);
    let mut calls = 0;
    let mut watch = |_: &Progress| {
        calls += 1;
        if calls == 5 {
            stuck.abort();
            cluster.worker(1, Fake::default());
        }
        ControlFlow::Continue(())
    };
    farm.open(&capture(1)).unwrap().evaluate(&request, &mut watch).unwrap();
    let counters = cluster.coordinator.broker.counters();
    // All six: it had three credits for each thread.
    assert_eq!((counters.returned, counters.workers_gone, counters.committed), (6, 1, 6));
}

/// Passes one connection after the other on to `target`; once more than `most` bytes have come by one, it passes no more
/// of them on for `stall`.
async fn stalling_proxy(target: String, most: usize, stall: Duration) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    tokio::spawn(async move {
        while let Ok((near, _)) = listener.accept().await {
            let far = TcpStream::connect(&target).await.unwrap();
            let ((mut from_near, mut to_near), (mut from_far, mut to_far)) = (near.into_split(), far.into_split());
            tokio::spawn(async move { tokio::io::copy(&mut from_far, &mut to_near).await });
            tokio::spawn(async move {
                let (mut passed, mut stalled, mut buffer) = (0, false, vec![0; 4096]);
                while let Ok(count @ 1..) = from_near.read(&mut buffer).await {
                    passed += count;
                    if passed > most && !std::mem::replace(&mut stalled, true) {
                        tokio::time::sleep(stall).await;
                    }
                    if to_far.write_all(&buffer[..count]).await.is_err() {
                        break;
                    }
                }
            });
        }
    });
    url
}

#[test]
fn a_worker_whose_films_are_stuck_in_the_network_still_beats() {
    let silence = Duration::from_secs(1);
    let cluster = Cluster::with_silence(silence);
    let target = cluster.url.strip_prefix("http://").unwrap().to_owned();
    let proxy = cluster.runtime.block_on(stalling_proxy(target, 100_000, 4 * silence));
    let worker = Worker::new("slow net", 1, Arc::new(FakeRenderer(Arc::new(Fake::default())))).unwrap();
    cluster.worker_by(&proxy, worker);
    let request = request(&capture(3), 2, Output::Films);
    let start = Instant::now();
    let answer = evaluate(&Farm::connect(&cluster.url).unwrap(), 3, &request).unwrap();
    assert!(start.elapsed() > 3 * silence, "the proxy has stalled nothing");
    assert_eq!(bits(&answer), bits(&evaluate(&embedded(1, Fake::default()).0, 3, &request).unwrap()));
    let counters = cluster.coordinator.broker.counters();
    assert_eq!((counters.silences, counters.returned, counters.workers_gone), (0, 0, 0));
}

#[test]
fn breaking_cancels_down_to_the_render_threads() {
    let (farm, fake) = embedded(2, Fake { delay: Duration::from_secs(1000), ..Fake::default() });
    let request = request(&capture(1), 2, Output::Statistics);
    let mut open = farm.open(&capture(1)).unwrap();
    let mut seen = Vec::new();
    let mut watch = |progress: &Progress| {
        seen.push(*progress);
        if seen.len() > 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let error = open.evaluate(&request, &mut watch).unwrap_err();
    assert!(matches!(error, EvaluateError::Cancelled));
    assert!(seen.iter().any(|p| p.tasks == 6 && p.workers == 1 && p.tasks_done == 0), "{seen:?}");
    drop(farm);
    // Both threads are free again: another evaluation, for which tiles would take as long, is at least begun and cancelled.
    assert!(matches!(open.evaluate(&request, &mut |_| ControlFlow::Break(())), Err(EvaluateError::Cancelled)));
    assert_eq!(fake.rendered.load(Ordering::Relaxed), 0);
}

#[test]
fn two_evaluations_share_a_farm() {
    let (farm, _) = embedded(2, Fake { delay: Duration::from_millis(2), ..Fake::default() });
    let request = request(&capture(2), 300, Output::Statistics);
    let expected = bits(&evaluate(&farm, 2, &request).unwrap());
    std::thread::scope(|scope| {
        let runs: Vec<_> = (0..3).map(|_| scope.spawn(|| bits(&evaluate(&farm, 2, &request).unwrap()))).collect();
        for run in runs {
            assert_eq!(run.join().unwrap(), expected);
        }
    });
}

fn refusal(result: Result<Evaluation, EvaluateError>) -> String {
    match result {
        Err(EvaluateError::Refused(text)) => text,
        other => panic!("not refused: {other:?}"),
    }
}

#[test]
fn every_fault_of_a_request_is_one_clear_error() {
    let (farm, _) = embedded(1, Fake::default());
    let good = request(&capture(2), 4, Output::Statistics);
    let refused = |change: &dyn Fn(&mut EvaluationRequest), expected: &str| {
        let mut request = good.clone();
        change(&mut request);
        let text = refusal(evaluate(&farm, 2, &request));
        assert!(text.contains(expected), "{text}");
    };
    refused(&|r| r.samples = 3, "samples: is 3, must be even");
    refused(&|r| r.samples = 20_000_000, "must be even and 2 to 10000000");
    refused(&|r| r.photos.clear(), "at least one photo");
    refused(&|r| r.photos = vec![1, 1], "names photo 1 twice");
    refused(&|r| r.photos = vec![2], "photo 2: the capture has 2 photos");
    refused(&|r| r.numbers = vec![("material.m.base_color.r".into(), 1.5)], "is set to 1.5");
    refused(&|r| r.numbers = vec![("material.m.shine".into(), 0.5)], "is no number of this capture");
    refused(&|r| r.numbers = vec![("material.m.base_color.r".into(), f64::NAN)], "must be finite");
    refused(&|r| r.columns = vec![r.columns[0].clone(); 257], "has 257 entries, the limit is 256");
    refused(&|r| r.columns[0].terms.clear(), "moves no number");
    refused(&|r| r.columns[0].terms[0].number = "sensor.read_noise".into(), "is no number that radiance depends on");
    // And the farm goes on.
    evaluate(&farm, 2, &good).unwrap();
}

#[test]
fn faults_of_captures_and_renderers_end_the_evaluation() {
    let ask = |farm: &Farm| evaluate(farm, 1, &request(&capture(1), 4, Output::Films));
    let (farm, _) = embedded(1, Fake { broken: true, ..Fake::default() });
    assert_eq!(refusal(ask(&farm)), "capture.toml: camera.distortion: folds the image; lower k1");
    let (farm, _) = embedded(1, Fake { panics: true, ..Fake::default() });
    assert!(refusal(ask(&farm)).contains("panicked"));

    let (farm, _) = embedded(1, Fake::default());
    let mut files = capture(1);
    files.0.insert("part.ply".into(), Arc::from(*b"ply\nnonsense"));
    let mut open = farm.open(&files).unwrap();
    let result = open.evaluate(&request(&capture(1), 4, Output::Films), &mut |_| ControlFlow::Continue(()));
    assert!(refusal(result).starts_with("part.ply: "));
}

#[test]
fn a_capture_without_its_photographs_renders_and_says_why_it_cannot_be_compared() {
    let (farm, _) = embedded(1, Fake::default());
    let mut files = capture(2);
    files.0.remove("photos/01.exr");
    let mut open = farm.open(&files).unwrap();
    let mut ask = |photos: Vec<usize>, output: Output| {
        let request = EvaluationRequest { photos, ..request(&capture(2), 2, output) };
        open.evaluate(&request, &mut |_| ControlFlow::Continue(()))
    };
    assert!(ask(vec![0, 1], Output::Films).is_ok());
    assert!(ask(vec![0], Output::Statistics).is_ok());
    assert!(refusal(ask(vec![0, 1], Output::Statistics)).starts_with("photos/01.exr: "));
}

#[test]
fn a_farm_that_nobody_serves_is_an_error_at_once() {
    let start = Instant::now();
    let Err(error) = Farm::connect("http://127.0.0.1:1") else { panic!("connected") };
    assert!(error.to_string().starts_with("the farm: "), "{error}");
    assert!(Farm::connect("not a url").is_err());
    assert!(start.elapsed() < Duration::from_secs(60));
}
