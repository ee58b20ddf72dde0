//! The pull loop against a coordinator whose every word the test chooses, with a renderer that only pretends.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

use bytes::Bytes;
use futures::future::BoxFuture;
use futures::{FutureExt, StreamExt};
use gonio_proto::Digest;
use gonio_proto::convert::film::{FilmAssembly, FilmShape};
use gonio_proto::convert::manifest::Manifest;
use gonio_proto::convert::request::Class;
use gonio_proto::convert::task::{AttemptId, Setup, Task};
use gonio_proto::wire::{self, from_worker, to_worker};
use gonio_scene::film::{PixelSet, Tile, TileFilm};
use gonio_scene::{Assets, Capture, Parameter, Result, SceneError};
use gonio_worker::pull::{Link, PullError};
use gonio_worker::renderer::{Loaded, Renderer, Scene, TileTask};
use gonio_worker::{BlobSource, Heart, Worker};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Status;

/// What the pretended renderer was asked, and how it behaves.
#[derive(Default)]
struct Fake {
    loaded: AtomicU64,
    prepared: AtomicU64,
    begun: AtomicU64,
    /// Renders until it is cancelled.
    endless: bool,
    /// Rendered slowly, but to the end.
    delay: Duration,
    /// First samples of the tasks, in the order in which they were begun.
    order: Mutex<Vec<u32>>,
    overflows: bool,
    broken: bool,
}

struct Pretend(Arc<Fake>);

impl Renderer for Pretend {
    fn load(&self, _: Capture, _: Assets) -> Arc<dyn Loaded> {
        self.0.loaded.fetch_add(1, Ordering::Relaxed);
        Arc::new(Pretend(Arc::clone(&self.0)))
    }
}

impl Loaded for Pretend {
    fn prepare(&self, _: &[(String, f64)], _: &[Parameter]) -> Result<Arc<dyn Scene>> {
        if self.0.broken {
            return Err(SceneError::new("part.ply", "has no triangle", "export it again"));
        }
        self.0.prepared.fetch_add(1, Ordering::Relaxed);
        Ok(Arc::new(Pretend(Arc::clone(&self.0))))
    }
}

impl Scene for Pretend {
    fn render(&self, task: &TileTask<'_>, cancel: &AtomicBool) -> Option<TileFilm> {
        self.0.begun.fetch_add(1, Ordering::Relaxed);
        self.0.order.lock().unwrap().push(task.samples.start);
        std::thread::sleep(self.0.delay);
        if self.0.endless {
            while !cancel.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
            return None;
        }
        let pixels = task.pixels.count();
        let value = if self.0.overflows { f32::INFINITY } else { task.seed as f32 + task.samples.start as f32 };
        Some(TileFilm { pixels, channels: 3, halves: 2, data: vec![value; 6 * pixels], invalid_samples: 2 })
    }

    fn first_hits(&self, task: &TileTask<'_>, _: &AtomicBool) -> Option<TileFilm> {
        let pixels = task.pixels.count();
        Some(TileFilm { pixels, channels: 10, halves: 1, data: vec![0.0; 10 * pixels], invalid_samples: 0 })
    }
}

struct Blobs(BTreeMap<Digest, Bytes>);

impl BlobSource for Blobs {
    fn get(&self, digest: Digest) -> BoxFuture<'_, std::result::Result<Bytes, String>> {
        let found = self.0.get(&digest).cloned().ok_or_else(|| "the network is down".to_owned());
        async move { found }.boxed()
    }
}

/// Counts beats; answers as it is told.
#[derive(Default)]
struct Beats {
    heard: AtomicU64,
    forgotten: AtomicBool,
}

impl Heart for Beats {
    fn beat(&self, worker: u64, epoch: u64) -> BoxFuture<'_, std::result::Result<(), Status>> {
        assert_eq!((worker, epoch), (1, 1));
        self.heard.fetch_add(1, Ordering::Relaxed);
        let forgotten = self.forgotten.load(Ordering::Relaxed);
        async move { if forgotten { Err(Status::not_found("who is it?")) } else { Ok(()) } }.boxed()
    }
}

const TOML: &str = r#"
    format = 1
    name = "nothing"
    camera = { width = 64, height = 32, fx = 60.0, fy = 60.0, cx = 32.0, cy = 16.0 }
    [[photo]]
    file = "none.exr"
    camera_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
"#;

/// The coordinator's end of a stream, and the worker at the other.
struct Script {
    say: mpsc::Sender<std::result::Result<wire::ToWorker, Status>>,
    hear: mpsc::Receiver<wire::FromWorker>,
    stop: Option<oneshot::Sender<()>>,
    worker: JoinHandle<std::result::Result<(), PullError>>,
    capture: Digest,
    beats: Arc<Beats>,
}

const SILENCE: Duration = Duration::from_millis(60);

impl Script {
    fn silent(fake: &Arc<Fake>, threads: usize, grace: Duration) -> Self {
        let manifest = Manifest { toml: Bytes::from_static(TOML.as_bytes()), files: BTreeMap::new() }.to_blob();
        let capture = Digest::of(&manifest);
        let blobs = Arc::new(Blobs([(capture, manifest)].into()));
        let (say, receiver) = mpsc::channel(64);
        let (outbound, hear) = mpsc::channel(4);
        let beats = Arc::new(Beats::default());
        let heart = Arc::clone(&beats) as Arc<dyn Heart>;
        let link = Link { outbound, inbound: ReceiverStream::new(receiver).boxed(), blobs, heart };
        let worker = Worker::new("test", threads, Arc::new(Pretend(Arc::clone(fake)))).unwrap().with_grace(grace);
        let (stop, stopped) = oneshot::channel();
        let worker = tokio::spawn(async move { worker.serve(link, stopped.map(|_| ())).await });
        Self { say, hear, stop: Some(stop), worker, capture, beats }
    }

    /// Hears the hello and answers it; hears the first request for tasks.
    async fn start(fake: &Arc<Fake>, threads: usize) -> Self {
        Self::start_with(fake, threads, Duration::ZERO).await
    }

    async fn start_with(fake: &Arc<Fake>, threads: usize, grace: Duration) -> Self {
        let mut script = Self::silent(fake, threads, grace);
        let Some(from_worker::Message::Hello(hello)) = script.hears().await else { panic!("no hello") };
        assert_eq!((hello.slots as usize, hello.version.as_str()), (threads, gonio_proto::VERSION));
        assert_eq!(hello.reserved_credits as usize, threads);
        let silence_milliseconds = SILENCE.as_millis() as u32;
        script.says(to_worker::Message::Welcome(wire::Welcome { worker: 1, epoch: 1, silence_milliseconds })).await;
        let asked = from_worker::Message::Ask(wire::Ask { credits: 3 * threads as u32 });
        assert_eq!(script.hears().await, Some(asked));
        script
    }

    async fn says(&self, message: to_worker::Message) {
        self.say.send(Ok(wire::ToWorker { message: Some(message) })).await.unwrap();
    }

    async fn hears(&mut self) -> Option<from_worker::Message> {
        self.hear.recv().await.map(|message| message.message.unwrap())
    }

    /// What it says next, except that it begins to render.
    async fn hears_news(&mut self) -> from_worker::Message {
        loop {
            match self.hears().await.expect("the worker ended") {
                from_worker::Message::Started(_) => {}
                message => return message,
            }
        }
    }

    async fn sets_up(&self, evaluation: u64, numbers: &[(&str, f64)], first_hits: bool) {
        self.sets_up_for(Class::Interactive, evaluation, numbers, first_hits).await;
    }

    async fn sets_up_for(&self, class: Class, evaluation: u64, numbers: &[(&str, f64)], first_hits: bool) {
        let numbers = numbers.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let setup = Setup {
            evaluation,
            capture: self.capture,
            numbers,
            columns: vec![],
            first_hits,
            class,
            trace_parent: String::new(),
        };
        self.says(to_worker::Message::Setup((&setup).into())).await;
    }

    async fn hands_out(&self, evaluation: u64, task: u64) -> Task {
        self.hands_out_together(evaluation, task..task + 1).await.remove(0)
    }

    async fn hands_out_together(&self, evaluation: u64, tasks: std::ops::Range<u64>) -> Vec<Task> {
        let task = |task: u64| Task {
            id: AttemptId { epoch: 1, evaluation, task, attempt: 0 },
            photo: 0,
            tile: Tile { x: 32, y: 0, width: 32, height: 32 },
            pixels: PixelSet::from_flags((0..1024).map(|i| i % 2 == 0)),
            samples: 10 + task as u32..20 + task as u32,
            seed: 100,
            difference_samples: 3,
            forward_samples: 3,
        };
        let tasks: Vec<_> = tasks.map(task).collect();
        let message = wire::Tasks { tasks: tasks.iter().map(wire::Task::from).collect() };
        self.says(to_worker::Message::Tasks(message)).await;
        tasks
    }

    async fn stops(&mut self) {
        self.stop.take().unwrap().send(()).unwrap();
        assert_eq!(self.hears_news().await, from_worker::Message::Leaving(wire::Leaving {}));
    }

    /// The film of the next commit, in which the worker asks for one task more.
    async fn film(&mut self, id: AttemptId, shape: FilmShape) -> TileFilm {
        assert_eq!(self.hears_news().await, from_worker::Message::Ask(wire::Ask { credits: 1 }));
        let mut assembly = FilmAssembly::new(shape);
        loop {
            match self.hears_news().await {
                from_worker::Message::Chunk(chunk) => assembly.add(chunk).unwrap(),
                from_worker::Message::Commit(commit) => {
                    assert_eq!(commit.id, Some(id.into()));
                    return assembly.finish(&commit).unwrap();
                }
                other => panic!("{other:?}"),
            }
        }
    }
}

const SHAPE: FilmShape = FilmShape { pixels: 512, channels: 3, halves: 2 };

#[tokio::test]
async fn a_task_comes_back_as_a_film() {
    let fake = Arc::new(Fake::default());
    let mut script = Script::start(&fake, 1).await;
    script.sets_up(7, &[], false).await;
    let task = script.hands_out(7, 3).await;
    let film = script.film(task.id, SHAPE).await;
    assert_eq!((film.data[0], film.invalid_samples), (113.0, 2));
    script.sets_up(8, &[], true).await;
    let task = script.hands_out(8, 0).await;
    script.film(task.id, FilmShape { channels: 10, halves: 1, ..SHAPE }).await;
    assert_eq!(fake.prepared.load(Ordering::Relaxed), 1, "both evaluations have the same scene");
}

#[tokio::test]
async fn captures_and_scenes_are_prepared_once_however_many_ask() {
    let fake = Arc::new(Fake::default());
    let mut script = Script::start(&fake, 2).await;
    for evaluation in 0..20 {
        let number = f64::from(evaluation as u32 % 10);
        script.sets_up(evaluation, &[("camera.cx", number)], false).await;
        for task in 0..4 {
            script.hands_out(evaluation, task).await;
        }
        for _ in 0..4 {
            while !matches!(script.hears_news().await, from_worker::Message::Commit(_)) {}
        }
    }
    assert_eq!(fake.loaded.load(Ordering::Relaxed), 1);
    // Ten scenes are asked for in turn, twice; eight are kept, so that none is found again.
    assert_eq!(fake.prepared.load(Ordering::Relaxed), 20);
}

#[tokio::test]
async fn it_beats_while_every_thread_renders_and_nobody_hears_its_films() {
    let fake = Arc::new(Fake { endless: true, ..Fake::default() });
    let mut script = Script::start(&fake, 1).await;
    script.sets_up(1, &[], false).await;
    let rendering = script.hands_out(1, 0).await;
    script.hands_out(1, 1).await;
    let started = wire::Started { id: Some(rendering.id.into()) };
    assert_eq!(script.hears().await, Some(from_worker::Message::Started(started)));
    let heard = script.beats.heard.load(Ordering::Relaxed);
    while script.beats.heard.load(Ordering::Relaxed) < heard + 5 {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    // Cancelled, both end without a result, and the thread is free.
    script.says(to_worker::Message::Cancel(wire::Cancel { evaluation: 1 })).await;
    for _ in 0..2 {
        assert_eq!(script.hears_news().await, from_worker::Message::Ask(wire::Ask { credits: 1 }));
    }
    assert_eq!(fake.begun.load(Ordering::Relaxed), 1);

    // Now nobody reads: tasks fill the channel, and the session waits. The beat goes on.
    let fake = Arc::new(Fake::default());
    let script = Script::start(&fake, 1).await;
    script.sets_up(1, &[], false).await;
    script.hands_out_together(1, 0..50).await;
    while fake.begun.load(Ordering::Relaxed) < 50 {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    let heard = script.beats.heard.load(Ordering::Relaxed);
    while script.beats.heard.load(Ordering::Relaxed) < heard + 5 {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
}

#[tokio::test]
async fn a_coordinator_that_has_forgotten_it_is_left() {
    let script = Script::start(&Arc::new(Fake::default()), 1).await;
    script.beats.forgotten.store(true, Ordering::Relaxed);
    let error = script.worker.await.unwrap().unwrap_err().to_string();
    assert!(error.contains("who is it?"), "{error}");
}

#[tokio::test]
async fn what_one_credit_bought_comes_back_one_by_one_and_is_paid_once() {
    let mut script = Script::start(&Arc::new(Fake::default()), 1).await;
    script.sets_up(7, &[], false).await;
    let tasks = script.hands_out_together(7, 0..3).await;
    let mut heard = Vec::new();
    for _ in 0..7 {
        heard.push(match script.hears_news().await {
            from_worker::Message::Commit(commit) => format!("commit {}", commit.id.unwrap().task),
            from_worker::Message::Ask(ask) => format!("ask {}", ask.credits),
            from_worker::Message::Chunk(chunk) => format!("film {}", chunk.id.unwrap().task),
            other => panic!("{other:?}"),
        });
    }
    assert_eq!(heard, ["film 0", "commit 0", "film 1", "commit 1", "ask 1", "film 2", "commit 2"]);
    assert_eq!(tasks.len(), 3);
}

#[tokio::test]
async fn an_attempt_that_is_revoked_stops_and_no_other() {
    let fake = Arc::new(Fake { endless: true, ..Fake::default() });
    let mut script = Script::start(&fake, 1).await;
    script.sets_up(1, &[], false).await;
    for task in 0..2 {
        script.hands_out(1, task).await;
    }
    let started = |task| wire::Started { id: Some(wire::AttemptId { epoch: 1, evaluation: 1, task, attempt: 0 }) };
    assert_eq!(script.hears().await, Some(from_worker::Message::Started(started(0))));
    let revoked = wire::Revoked { attempts: vec![started(0).id.unwrap()] };
    script.says(to_worker::Message::Revoked(revoked)).await;
    let mut heard = [script.hears().await.unwrap(), script.hears().await.unwrap()];
    // The next begins on the thread before or after the first's end is said.
    heard.sort_by_key(|message| matches!(message, from_worker::Message::Started(_)));
    assert_eq!(heard[0], from_worker::Message::Ask(wire::Ask { credits: 1 }));
    assert_eq!(heard[1], from_worker::Message::Started(started(1)));
}

#[tokio::test]
async fn interactive_tasks_do_not_wait_for_a_sweeps() {
    let fake = Arc::new(Fake { delay: Duration::from_millis(20), ..Fake::default() });
    let mut script = Script::start(&fake, 1).await;
    script.sets_up_for(Class::Batch, 1, &[], false).await;
    script.sets_up_for(Class::Interactive, 2, &[], false).await;
    script.hands_out_together(1, 0..20).await;
    assert!(matches!(script.hears().await, Some(from_worker::Message::Started(_))));
    script.hands_out_together(2, 100..103).await;
    for _ in 0..23 {
        while !matches!(script.hears_news().await, from_worker::Message::Commit(_)) {}
    }
    let order = fake.order.lock().unwrap().clone();
    let last = order.iter().rposition(|start| *start >= 110).unwrap();
    // Behind the one that was being rendered, and another that may have begun before they were heard of.
    assert!(last <= 5, "{order:?}");
}

#[tokio::test]
async fn a_worker_that_stops_hands_back_what_waits_and_what_outlasts_its_grace() {
    let fake = Arc::new(Fake { endless: true, ..Fake::default() });
    for grace in [0, 50] {
        let mut script = Script::start_with(&fake, 1, Duration::from_millis(grace)).await;
        script.sets_up(1, &[], false).await;
        let (rendering, waiting) = (script.hands_out(1, 0).await, script.hands_out(1, 1).await);
        let started = wire::Started { id: Some(rendering.id.into()) };
        assert_eq!(script.hears().await, Some(from_worker::Message::Started(started)));
        // It has heard of both when it has heard what comes after them.
        script.sets_up(2, &[], true).await;
        let done = script.hands_out(2, 0).await;
        while script.say.capacity() < 64 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
        script.stops().await;
        let mut released = Vec::new();
        while let Some(message) = script.hears().await {
            match message {
                from_worker::Message::Released(wire::Released { id, text }) if text.is_empty() => released.push(id),
                from_worker::Message::Ask(_) => {}
                other => panic!("{other:?}"),
            }
        }
        assert_eq!(released, [waiting.id, done.id, rendering.id].map(|id| Some(id.into())));
        drop(script.say);
        script.worker.await.unwrap().unwrap();
    }
}

#[tokio::test]
async fn a_worker_that_stops_finishes_what_it_renders_within_its_grace() {
    let fake = Arc::new(Fake { delay: Duration::from_millis(50), ..Fake::default() });
    let mut script = Script::start_with(&fake, 1, Duration::from_secs(60)).await;
    script.sets_up(1, &[], false).await;
    let task = script.hands_out(1, 0).await;
    assert!(matches!(script.hears().await, Some(from_worker::Message::Started(_))));
    script.stops().await;
    // What crosses with its word goes back at once.
    let late = script.hands_out(1, 1).await;
    let released = wire::Released { id: Some(late.id.into()), text: String::new() };
    assert_eq!(script.hears_news().await, from_worker::Message::Released(released));
    script.film(task.id, SHAPE).await;
    assert_eq!(script.hears().await, None);
    drop(script.say);
    script.worker.await.unwrap().unwrap();
}

#[tokio::test]
async fn what_cannot_be_rendered_is_said_and_why() {
    let next = async |fake: Fake, capture: Option<Digest>| {
        let mut script = Script::start(&Arc::new(fake), 1).await;
        script.capture = capture.unwrap_or(script.capture);
        script.sets_up(1, &[], false).await;
        script.hands_out(1, 0).await;
        assert_eq!(script.hears_news().await, from_worker::Message::Ask(wire::Ask { credits: 1 }));
        match script.hears_news().await {
            from_worker::Message::Failed(failed) => ("failed", failed.text),
            from_worker::Message::Released(released) => ("released", released.text),
            other => panic!("{other:?}"),
        }
    };
    let broken = next(Fake { broken: true, ..Fake::default() }, None).await;
    assert_eq!(broken, ("failed", "part.ply: has no triangle; export it again".to_owned()));
    let overflow = next(Fake { overflows: true, ..Fake::default() }, None).await;
    assert!(overflow.0 == "failed" && overflow.1.contains("overflows"), "{overflow:?}");
    let missing = next(Fake::default(), Some(Digest::of(b"elsewhere"))).await;
    assert_eq!(missing, ("released", "the capture's manifest: the network is down".to_owned()));
}

#[tokio::test]
async fn a_coordinator_that_breaks_the_protocol_is_left() {
    let fake = Arc::new(Fake::default());
    let ends = async |script: Script, expected: &str| {
        let error = script.worker.await.unwrap().unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    let script = Script::silent(&fake, 1, Duration::ZERO);
    script.says(to_worker::Message::Cancel(wire::Cancel { evaluation: 1 })).await;
    ends(script, "must begin with Welcome").await;
    let script = Script::start(&fake, 1).await;
    script.hands_out(9, 0).await;
    ends(script, "no Setup came before it").await;
    let script = Script::start(&fake, 1).await;
    script.says(to_worker::Message::Welcome(wire::Welcome::default())).await;
    ends(script, "came a second time").await;
    let script = Script::start(&fake, 1).await;
    script.says(to_worker::Message::Setup(wire::Setup::default())).await;
    ends(script, "Setup.capture_digest").await;
    let script = Script::start(&fake, 1).await;
    script.sets_up(1, &[], false).await;
    let tasks = vec![wire::Task { tile: None, ..Default::default() }];
    script.says(to_worker::Message::Tasks(wire::Tasks { tasks })).await;
    ends(script, "Task.tile: is absent").await;
    let script = Script::start(&fake, 1).await;
    script.say.send(Ok(wire::ToWorker { message: None })).await.unwrap();
    ends(script, "is absent or unknown here").await;
    let script = Script::start(&fake, 1).await;
    script.say.send(Err(Status::unavailable("restarting"))).await.unwrap();
    ends(script, "restarting").await;
}
