//! An evaluation while it runs, as the broker, the workers' sessions and the client's stream see it.

use crate::aggregate::Reduction;
use crate::aggregate::reduction::Added;
use crate::journal::Journal;
use crate::split::{Part, Split};
use gonio_proto::Key;
use gonio_proto::convert::request::Requester;
use gonio_proto::convert::task::{AttemptId, Setup, Task};
use gonio_scene::film::TileFilm;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::oneshot;

/// Why an evaluation ended without an answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// Whether another try would fail alike.
    pub request_at_fault: bool,
    /// What is wrong and how to mend it.
    pub text: String,
}

#[allow(clippy::needless_pass_by_value)] // Their place is in `map_err`.
impl Failure {
    /// A failure of the request or its capture.
    pub fn of_request(text: impl ToString) -> Self {
        Self { request_at_fault: true, text: text.to_string() }
    }

    /// A failure of the farm.
    pub fn of_farm(text: impl ToString) -> Self {
        Self { request_at_fault: false, text: text.to_string() }
    }
}

/// How an evaluation ended: all tiles are reduced, or why not.
pub type Outcome = Result<(), Failure>;

/// What is the same for as long as an evaluation runs, and the reduction of what it yields.
#[derive(Debug)]
pub struct Active {
    /// Whose it is.
    pub requester: Requester,
    /// What workers are told before their first task of it.
    pub setup: Setup,
    /// Its tasks.
    pub split: Arc<Split>,
    /// Index in the capture of each of the request's photos.
    pub photos: Vec<usize>,
    /// Of every random number.
    pub seed: u64,
    /// What committed films are added to.
    pub reduction: Reduction,
    /// Where its tiles are written down, if it is to outlive this coordinator.
    keeper: Option<(Journal, Key)>,
    /// Taken by the first who ends the evaluation; the client's stream waits at the other end.
    outcome: Mutex<Option<oneshot::Sender<Outcome>>>,
}

impl Active {
    /// An evaluation that runs, and where its outcome will be told.
    #[must_use]
    pub fn new(
        requester: Requester,
        setup: Setup,
        split: Arc<Split>,
        photos: Vec<usize>,
        seed: u64,
        reduction: Reduction,
    ) -> (Self, oneshot::Receiver<Outcome>) {
        let (sender, receiver) = oneshot::channel();
        let outcome = Mutex::new(Some(sender));
        (Self { requester, setup, split, photos, seed, reduction, keeper: None, outcome }, receiver)
    }

    /// The same evaluation, whose tiles are written down as `key`'s.
    #[must_use]
    pub fn kept(mut self, journal: Journal, key: Key) -> Self {
        self.keeper = Some((journal, key));
        self
    }

    /// Adds the film of a task that is committed, and does what follows from it. Call it where blocking is allowed.
    pub fn add(&self, part: &Part, film: TileFilm) {
        let added = self.reduction.add(part, film);
        if let Some((journal, key)) = self.keeper.as_ref().filter(|_| added != Added::Film)
            && let Some(reduced) = self.reduction.reduced(part.tile)
        {
            journal.keep(*key, reduced.to_wire(part.tile as u64));
        }
        if added == Added::All {
            self.end(Ok(()));
        }
    }

    /// Ends the evaluation, unless it has ended.
    pub fn end(&self, outcome: Outcome) {
        if let Some(sender) = self.outcome.lock().unwrap_or_else(PoisonError::into_inner).take() {
            // Nobody listens any more when the client has gone: then it is being cancelled anyway.
            let _ = sender.send(outcome);
        }
    }

    /// The part of the work that a task is.
    #[must_use]
    pub fn part(&self, task: u64) -> Option<Part> {
        self.split.part(task)
    }

    /// An attempt's task, as a worker is told.
    #[must_use]
    pub fn task(&self, id: AttemptId) -> Option<Task> {
        let part = self.part(id.task)?;
        let work = &self.split.tiles[part.tile];
        Some(Task {
            id,
            photo: self.photos[work.photo],
            tile: work.tile,
            pixels: work.pixels.clone(),
            samples: part.samples,
            seed: self.seed,
            difference_samples: part.difference_samples,
            forward_samples: part.forward_samples,
        })
    }

    /// A task for people: which photo, which tile.
    #[must_use]
    pub fn describe(&self, task: u64) -> String {
        match self.part(task).map(|part| (&self.split.tiles[part.tile], part.chunk)) {
            Some((work, chunk)) => {
                format!(
                    "task {task} (photo {}, tile at {}, {}, chunk {chunk})",
                    self.photos[work.photo], work.tile.x, work.tile.y
                )
            }
            None => format!("task {task}"),
        }
    }
}
