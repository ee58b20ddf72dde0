//! How fast tasks are handed out, how long a worker waits for one, and what a task costs that nobody has touched.
//!
//! `cargo bench -p gonio-coordinator --bench assignments`. A thousand simulated workers in this process, each with a stream
//! of its own, say and hear what real ones do; their films are one pixel large, so that what is measured is the broker, the
//! sessions and the conversions, not the reduction.

use anyhow::Context;
use futures::StreamExt;
use gonio_coordinator::aggregate::reduction::ReducedPhoto;
use gonio_coordinator::aggregate::{Measured, Recipe, Reduction};
use gonio_coordinator::broker::{Active, Broker, Failure, SILENCE, ToWorker, session};
use gonio_coordinator::journal::{self, Journal};
use gonio_coordinator::split::{CHUNK_SAMPLES, PhotoArea, Split};
use gonio_coordinator::store::Blobs;
use gonio_proto::Digest;
use gonio_proto::convert::film::film_to_wire;
use gonio_proto::convert::key::Key;
use gonio_proto::convert::request::{Class, Requester};
use gonio_proto::convert::task::{Setup, tasks_from_wire};
use gonio_proto::wire::{self, from_worker, to_worker};
use gonio_scene::capture::Sensor;
use gonio_scene::derivative::Plan;
use gonio_scene::film::TileFilm;
use gonio_scene::image::Image;
use gonio_scene::{Capture, Output, Photograph};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, oneshot};
use tokio_stream::wrappers::{ReceiverStream, UnboundedReceiverStream};

const WORKERS: usize = 1000;

/// Tiles a side of the photo.
const SIDE: u32 = 100;

/// Chunks of samples, each a task, of every tile.
const CHUNKS: u32 = 10;

/// Threads that each worker claims to have: so many that a credit never buys more than one task.
const SLOTS: u32 = 64;

fn main() -> anyhow::Result<()> {
    for side in [500, 1000, 2000] {
        memory(side);
    }
    let runtime = tokio::runtime::Runtime::new()?;
    for round in 0..3 {
        runtime.block_on(assign(round, None))?;
    }
    for round in 0..3 {
        let folder = tempfile::tempdir()?;
        let store = folder.path().to_str().context("a folder whose name is text")?;
        runtime.block_on(assign(round, Some(Blobs::open(store)?)))?;
    }
    Ok(())
}

type Evaluation = (Arc<Active>, oneshot::Receiver<Result<(), Failure>>);

/// An evaluation with the tasks of a split.
fn evaluation(number: u64, split: Split, photos: Vec<ReducedPhoto>, keeper: Option<(Journal, Key)>) -> Evaluation {
    let split = Arc::new(split);
    let reduction = Reduction::new(Output::Statistics, Arc::clone(&split), photos);
    let setup = Setup {
        evaluation: number,
        capture: Digest::of(b"bench"),
        numbers: vec![],
        columns: vec![],
        first_hits: false,
        class: Class::Batch,
        trace_parent: String::new(),
    };
    let (active, outcome) = Active::new(Requester::default(), setup, split, vec![0], 1, reduction);
    let active = match keeper {
        Some((journal, key)) => active.kept(journal, key),
        None => active,
    };
    (Arc::new(active), outcome)
}

/// `SIDE` x `SIDE` tiles, one pixel of each of which counts, times `chunks` of samples.
fn small_tasks(number: u64, chunks: u32, keeper: Option<(Journal, Key)>) -> Evaluation {
    let side = 32 * SIDE;
    let pixels = (side * side) as usize;
    let first = |i: usize| i.is_multiple_of(32);
    let counts = (0..pixels).map(|i| first(i) && first(i / side as usize)).collect();
    let image = Image { width: side, height: side, pixels: vec![[0.5; 3]; pixels] };
    let photograph = Arc::new(Measured::All(Photograph::new(image, counts, 0)));
    let area = PhotoArea { width: side, height: side, counted: Some(&photograph) };
    let split = Split::new(&[area], 2 * CHUNK_SAMPLES * chunks, Output::Statistics, 0).expect("a split");
    let recipe = Recipe::new(&Plan::default(), &Capture::default(), 0);
    let sensor = Sensor { read_noise: 0.01, ..Sensor::default() };
    let photograph = Some(photograph);
    let photo = ReducedPhoto { index: 0, width: side, height: side, recipe, sensor, photograph, peak: 0.5 };
    evaluation(number, split, vec![photo], keeper)
}

/// Prints what `side` x `side` queued tasks of full tiles take, by how much the process has grown.
fn memory(side: u32) {
    let broker = Broker::new(1, SILENCE);
    let (start, before) = (Instant::now(), resident());
    let area = PhotoArea { width: 32 * side, height: 32 * side, counted: None };
    let split = Split::new(&[area], 2, Output::Statistics, 0).expect("a split");
    let registration = broker.submit(evaluation(1, split, vec![], None).0);
    let (took, tasks) = (start.elapsed(), side * side);
    match resident().zip(before) {
        Some((after, before)) => {
            let each = after.saturating_sub(before) as f64 / f64::from(tasks);
            println!("{tasks} tasks queued in {took:.2?}: {each:.0} bytes each");
        }
        None => println!("{tasks} tasks queued in {took:.2?}; this system does not say how large a process is"),
    }
    drop(registration);
}

/// Resident bytes of this process.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| 1024 * kilobytes)
}

/// Prints assignments a second and how long workers waited for them. With a store, every task is a tile of its own, and all
/// that is reduced is in the store when the clock stops.
async fn assign(round: u32, store: Option<Blobs>) -> anyhow::Result<()> {
    let journal = match &store {
        Some(blobs) => Some(journal::open(blobs).await?.0),
        None => None,
    };
    let keeper = journal.clone().zip(Some(Key::fresh()?));
    let broker = Broker::new(1, Duration::from_secs(3600));
    let waits = Arc::new(Mutex::new(Vec::new()));
    let workers: Vec<_> = (0..WORKERS)
        .map(|i| {
            let (say, said) = mpsc::channel(64);
            let hear = session::serve(Arc::clone(&broker), ReceiverStream::new(said));
            tokio::spawn(work(i, say, hear, Arc::clone(&waits)))
        })
        .collect();
    while broker.workers() < WORKERS {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    let chunks = if keeper.is_some() { 1 } else { CHUNKS };
    let (active, outcome) = small_tasks(broker.new_evaluation(), chunks, keeper.clone());
    let start = Instant::now();
    if let Some((journal, key)) = &keeper {
        anyhow::ensure!(journal.accept(*key, wire::EvaluationRequest::default()).await, "the journal is lost");
    }
    let registration = broker.submit(active);
    outcome.await?.map_err(|failure| anyhow::anyhow!(failure.text))?;
    if let Some(journal) = &journal {
        journal.release().await;
    }
    let took = start.elapsed();
    drop(registration);
    broker.close();
    for worker in workers {
        worker.await??;
    }
    let mut waits = std::mem::take(&mut *waits.lock().unwrap_or_else(PoisonError::into_inner));
    waits.sort_unstable();
    let counters = broker.counters();
    println!(
        "round {round}, {}: {WORKERS} workers, {} tasks in {took:.2?}: {:.0} assignments/s, each committed; {} messages of tasks, \
         from asking to hearing p50 {:.2?}, p99 {:.2?}",
        if journal.is_some() { "in a folder" } else { "in memory" },
        counters.committed,
        counters.granted as f64 / took.as_secs_f64(),
        waits.len(),
        waits[waits.len() / 2],
        waits[waits.len() * 99 / 100],
    );
    Ok(())
}

/// One worker: asks, commits at once, asks again, until the broker closes.
async fn work(
    number: usize,
    say: mpsc::Sender<Result<wire::FromWorker, tonic::Status>>,
    mut hear: UnboundedReceiverStream<ToWorker>,
    waits: Arc<Mutex<Vec<Duration>>>,
) -> anyhow::Result<()> {
    let says = async |message| say.send(Ok(wire::FromWorker { message: Some(message) })).await;
    let version = gonio_proto::VERSION.to_owned();
    let hello = wire::Hello { name: format!("simulated-{number}"), slots: SLOTS, version, reserved_credits: 0 };
    says(from_worker::Message::Hello(hello)).await?;
    says(from_worker::Message::Ask(wire::Ask { credits: 1 })).await?;
    // What is asked before there is anything waits for the evaluation, not for the broker.
    let mut asked = None;
    let film = TileFilm { pixels: 1, channels: 3, halves: 2, data: vec![0.5; 6], invalid_samples: 0 };
    while let Some(Ok(message)) = hear.next().await {
        let Some(to_worker::Message::Tasks(tasks)) = message.message else { continue };
        if let Some(asked) = asked.replace(Instant::now()) {
            waits.lock().unwrap_or_else(PoisonError::into_inner).push(Instant::elapsed(&asked));
        }
        for task in tasks_from_wire(tasks)? {
            for message in film_to_wire(task.id, &film, Duration::from_millis(100)) {
                // The broker may have closed: the evaluation ends with the last commit, not with the last word.
                if say.send(Ok(message)).await.is_err() {
                    return Ok(());
                }
            }
        }
        asked = Some(Instant::now());
        if says(from_worker::Message::Ask(wire::Ask { credits: 1 })).await.is_err() {
            break;
        }
    }
    Ok(())
}
