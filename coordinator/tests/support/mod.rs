//! A capture in a coordinator's store, and a worker whose every word the test chooses.

// Each test uses its own part; a helper of tests may unwrap as they do.
#![allow(dead_code, missing_docs, clippy::unwrap_used)]

use futures::{FutureExt, StreamExt};
use gonio_coordinator::Coordinator;
use gonio_coordinator::broker::ToWorker;
use gonio_coordinator::store::Blobs;
use gonio_proto::Digest;
use gonio_proto::convert::event::{Event, FilmCollector};
use gonio_proto::convert::film::film_to_wire;
use gonio_proto::convert::manifest::pack;
use gonio_proto::convert::request::request_to_wire;
use gonio_proto::convert::task::{AttemptId, Task, tasks_from_wire};
use gonio_proto::wire::{self, from_worker, to_worker};
use gonio_scene::files::{Files, MemoryFiles};
use gonio_scene::film::TileFilm;
use gonio_scene::{EvaluationRequest, Film, Output};
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio_stream::wrappers::{ReceiverStream, UnboundedReceiverStream};
use tonic::Status;

/// Of every test's coordinator.
pub const SILENCE: Duration = gonio_coordinator::broker::SILENCE;

const TOML: &str = r#"
    format = 1
    name = "two tiles"
    camera = { width = 64, height = 32, fx = 60.0, fy = 60.0, cx = 32.0, cy = 16.0 }
    [[photo]]
    file = "none.exr"
    camera_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
"#;

/// A coordinator whose store holds a capture of one photo of two tiles.
pub async fn coordinator() -> (Coordinator, Digest) {
    let coordinator = Coordinator::new(Blobs::in_memory(), SILENCE);
    let digest = store(&coordinator, &files()).await;
    (coordinator, digest)
}

/// A capture of one photo of two tiles.
pub fn files() -> MemoryFiles {
    MemoryFiles([("capture.toml".to_owned(), Arc::from(TOML.as_bytes()))].into())
}

/// Puts a capture into a coordinator's store.
pub async fn store(coordinator: &Coordinator, files: &MemoryFiles) -> Digest {
    let packed = pack(files).unwrap();
    for (path, (digest, _)) in &packed.manifest.files {
        let blob = bytes::Bytes::from_owner(files.read(path).unwrap());
        coordinator.blobs.put(*digest, blob).await.unwrap();
    }
    let manifest = packed.manifest.to_blob();
    let digest = Digest::of(&manifest);
    coordinator.blobs.put(digest, manifest).await.unwrap();
    digest
}

/// A request for the photo's film: two tiles times `chunks` tasks.
pub fn request(digest: Digest, chunks: u32) -> wire::EvaluationRequest {
    let request = EvaluationRequest {
        numbers: vec![],
        columns: vec![],
        photos: vec![0],
        samples: chunks * 128,
        difference_samples: 0,
        forward_samples: 0,
        seed: 3,
        output: Output::Films,
    };
    request_to_wire(digest, &request)
}

/// A worker played by the test.
pub struct Script {
    pub say: mpsc::Sender<Result<wire::FromWorker, Status>>,
    hear: UnboundedReceiverStream<ToWorker>,
    /// Tasks that came with the last one.
    along: VecDeque<Task>,
    /// Beats; ends with the script.
    heart: JoinSet<()>,
    worker: u64,
    epoch: u64,
}

impl Script {
    /// Connects; says nothing yet.
    pub fn silent(coordinator: &Coordinator) -> Self {
        let (say, receiver) = mpsc::channel(64);
        let hear = coordinator.work(ReceiverStream::new(receiver));
        Self { say, hear, along: VecDeque::new(), heart: JoinSet::new(), worker: 0, epoch: 0 }
    }

    /// Connects, says hello, is welcomed, asks for `tasks`.
    pub async fn join(coordinator: &Coordinator, credits: u32) -> Self {
        Self::join_with(coordinator, credits, 0).await
    }

    /// The same, with some of its credits for interactive evaluations only.
    pub async fn join_with(coordinator: &Coordinator, credits: u32, reserved_credits: u32) -> Self {
        let mut script = Self::silent(coordinator);
        let version = gonio_proto::VERSION.to_owned();
        let hello = wire::Hello { name: "script".into(), slots: 1, version, reserved_credits };
        script.says(from_worker::Message::Hello(hello)).await;
        let to_worker::Message::Welcome(welcome) = script.hears().await else { panic!("not welcome") };
        assert_eq!(welcome.silence_milliseconds, 4000);
        (script.worker, script.epoch) = (welcome.worker, welcome.epoch);
        script.beats(coordinator);
        script.asks(credits).await;
        script
    }

    /// Beats from now on.
    pub fn beats(&mut self, coordinator: &Coordinator) {
        let (coordinator, worker, epoch) = (coordinator.clone(), self.worker, self.epoch);
        self.heart.spawn(async move {
            while coordinator.beat(worker, epoch).is_ok() {
                tokio::time::sleep(SILENCE / 4).await;
            }
        });
    }

    /// Beats no more.
    pub fn falls_silent(&mut self) {
        self.heart.abort_all();
    }

    /// Its process dies; the coordinator knows when this returns.
    pub async fn dies(self) {
        let Self { say, mut hear, .. } = self;
        drop(say);
        while hear.next().await.is_some() {}
    }

    pub async fn says(&self, message: from_worker::Message) {
        self.say.send(Ok(wire::FromWorker { message: Some(message) })).await.unwrap();
    }

    pub async fn asks(&self, credits: u32) {
        self.says(from_worker::Message::Ask(wire::Ask { credits })).await;
    }

    /// What the coordinator says next.
    pub async fn hears(&mut self) -> to_worker::Message {
        self.hear.next().await.expect("the stream ended").unwrap().message.unwrap()
    }

    /// Why the coordinator ended the stream.
    pub async fn refusal(&mut self) -> Status {
        loop {
            match self.hear.next().await {
                Some(Ok(_)) => {}
                Some(Err(status)) => return status,
                None => panic!("ended without a reason"),
            }
        }
    }

    /// The next task; the setup that comes before the first is passed over.
    pub async fn task(&mut self) -> Task {
        if self.along.is_empty() {
            self.along = self.tasks().await.into();
        }
        self.along.pop_front().unwrap()
    }

    /// What the next credit buys.
    pub async fn tasks(&mut self) -> Vec<Task> {
        loop {
            match self.hears().await {
                to_worker::Message::Tasks(tasks) => return tasks_from_wire(tasks).unwrap(),
                to_worker::Message::Setup(_) => {}
                other => panic!("no task but {other:?}"),
            }
        }
    }

    /// Whether nothing was said to it that it has not heard.
    pub fn hears_nothing(&mut self) -> bool {
        self.along.is_empty() && self.hear.next().now_or_never().is_none()
    }

    /// Begins to render.
    pub async fn starts(&self, task: &Task) {
        self.says(from_worker::Message::Started(wire::Started { id: Some(task.id.into()) })).await;
    }

    /// Sends the good result of a task.
    pub async fn commits(&self, task: &Task) {
        self.sends(task.id, &film(task)).await;
    }

    pub async fn sends(&self, id: AttemptId, film: &TileFilm) {
        for message in film_to_wire(id, film, Duration::ZERO) {
            self.say.send(Ok(message)).await.unwrap();
        }
    }

    /// Sends the good result of a task that took a tenth of a second.
    pub async fn commits_slowly(&self, task: &Task) {
        tokio::time::sleep(Duration::from_millis(100)).await;
        for message in film_to_wire(task.id, &film(task), Duration::from_millis(100)) {
            self.say.send(Ok(message)).await.unwrap();
        }
    }
}

/// What an honest worker returns for a task, of magnitudes so different that the order of addition shows.
pub fn film(task: &Task) -> TileFilm {
    let value = |i: usize| {
        let z = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_mul(u64::from(task.samples.start) + 7);
        (z >> 40) as f32 * [1.0, 1e-5, 300.0][(task.samples.start as usize / 64) % 3]
    };
    let data = (0..2 * 3 * task.pixels.count()).map(value).collect();
    TileFilm { pixels: task.pixels.count(), channels: 3, halves: 2, data, invalid_samples: 0 }
}

/// The end of an evaluation: its films, or why there are none.
pub async fn answer(mut events: ReceiverStream<wire::EvaluationEvent>) -> Result<Vec<Film>, String> {
    let mut films = FilmCollector::default();
    while let Some(event) = events.next().await {
        match Event::try_from(event).unwrap() {
            Event::Film(chunk) => films.add(chunk).unwrap(),
            Event::Finished { .. } => return Ok(films.finish().unwrap()),
            Event::Failed { text, .. } => return Err(text),
            _ => {}
        }
    }
    panic!("the stream ended without an end");
}

/// The bits of films.
pub fn bits(films: &[Film]) -> Vec<u32> {
    films.iter().flat_map(|f| &f.channels).flatten().map(|v| v.to_bits()).collect()
}
