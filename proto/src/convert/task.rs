//! What a worker is told to render, and how it says who it is.

use super::request::{Class, columns_from_wire, columns_to_wire, numbers_from_wire, numbers_to_wire};
use super::{Digest, Result, WireError, named, required, text};
use crate::{limits, wire};
use bytes::Bytes;
use gonio_scene::Parameter;
use gonio_scene::film::{LARGEST_TILE, PixelSet, TILE, Tile};
use prost::Message;
use std::ops::Range;

/// Identifies one try at one task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AttemptId {
    /// The coordinator's incarnation.
    pub epoch: u64,
    /// The evaluation, among those of this epoch.
    pub evaluation: u64,
    /// Index of the task in its evaluation.
    pub task: u64,
    /// 0 for the first try.
    pub attempt: u32,
}

impl From<AttemptId> for wire::AttemptId {
    fn from(id: AttemptId) -> Self {
        Self { epoch: id.epoch, evaluation: id.evaluation, task: id.task, attempt: id.attempt }
    }
}

impl AttemptId {
    /// The id of a message that carries one.
    ///
    /// # Errors
    /// It carries none.
    pub fn from_wire(field: &str, id: Option<wire::AttemptId>) -> Result<Self> {
        let wire::AttemptId { epoch, evaluation, task, attempt } = required(field, id)?;
        Ok(Self { epoch, evaluation, task, attempt })
    }
}

impl std::fmt::Display for AttemptId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "evaluation {} task {} attempt {} (epoch {})", self.evaluation, self.task, self.attempt, self.epoch)
    }
}

/// Who a worker is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hello {
    /// For people.
    pub name: String,
    /// Tasks rendered at the same time, 1 to [`limits::SLOTS`].
    pub slots: u32,
    /// Version of its program.
    pub version: String,
    /// Of its credits, how many are kept for interactive evaluations.
    pub reserved_credits: u32,
}

impl From<Hello> for wire::Hello {
    fn from(hello: Hello) -> Self {
        Self { name: hello.name, slots: hello.slots, version: hello.version, reserved_credits: hello.reserved_credits }
    }
}

impl TryFrom<wire::Hello> for Hello {
    type Error = WireError;

    fn try_from(hello: wire::Hello) -> Result<Self> {
        if hello.slots == 0 || hello.slots > limits::SLOTS {
            return Err(WireError::new("Hello.slots", format!("is {}, must be 1 to {}", hello.slots, limits::SLOTS)));
        }
        let name = text(&named("Hello.name", hello.name, limits::NAME_BYTES)?);
        let version = text(&named("Hello.version", hello.version, limits::NAME_BYTES)?);
        Ok(Self { name, slots: hello.slots, version, reserved_credits: hello.reserved_credits.min(limits::CREDITS) })
    }
}

/// What all tasks of an evaluation share.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// The evaluation.
    pub evaluation: u64,
    /// The capture.
    pub capture: Digest,
    /// Numbers that differ from the capture's file.
    pub numbers: Vec<(String, f64)>,
    /// Derivatives to render.
    pub columns: Vec<Parameter>,
    /// First hits instead of radiance.
    pub first_hits: bool,
    /// How urgent it is.
    pub class: Class,
    /// The span of which tasks' spans are children, as a W3C traceparent; empty where nothing is traced.
    pub trace_parent: String,
}

impl From<&Setup> for wire::Setup {
    fn from(setup: &Setup) -> Self {
        Self {
            evaluation: setup.evaluation,
            capture_digest: setup.capture.to_wire(),
            numbers: numbers_to_wire(&setup.numbers),
            columns: columns_to_wire(&setup.columns),
            first_hits: setup.first_hits,
            class: setup.class.to_wire(),
            trace_parent: setup.trace_parent.clone(),
        }
    }
}

impl TryFrom<wire::Setup> for Setup {
    type Error = WireError;

    fn try_from(setup: wire::Setup) -> Result<Self> {
        Ok(Self {
            evaluation: setup.evaluation,
            capture: Digest::from_wire("Setup.capture_digest", &setup.capture_digest)?,
            numbers: numbers_from_wire("Setup.numbers", setup.numbers)?,
            columns: columns_from_wire("Setup.columns", setup.columns)?,
            first_hits: setup.first_hits,
            class: Class::from_wire("Setup.class", setup.class)?,
            trace_parent: text(&setup.trace_parent),
        })
    }
}

impl Setup {
    /// Names what a prepared scene depends on: equal keys, equal scenes.
    #[must_use]
    pub fn scene_key(&self) -> Digest {
        let scene =
            wire::Setup { evaluation: 0, first_hits: false, class: 0, trace_parent: String::new(), ..self.into() };
        Digest::of(&scene.encode_to_vec())
    }
}

/// The tasks that one credit buys.
///
/// # Errors
/// None, too many, or one that is broken.
pub fn tasks_from_wire(tasks: wire::Tasks) -> Result<Vec<Task>> {
    if tasks.tasks.is_empty() {
        return Err(WireError::new("Tasks.tasks", "is empty"));
    }
    super::at_most("Tasks.tasks", tasks.tasks.len(), limits::TASKS_AT_ONCE)?;
    tasks.tasks.into_iter().map(Task::try_from).collect()
}

/// One tile x sample range.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Task {
    /// This try at it.
    pub id: AttemptId,
    /// Index of the photo in the capture.
    pub photo: usize,
    /// The tile; its sides are at most [`LARGEST_TILE`].
    pub tile: Tile,
    /// The wanted pixels of the tile: at most as many as a tile of [`TILE`] pixels a side has.
    pub pixels: PixelSet,
    /// Samples of each half; empty for first hits.
    pub samples: Range<u32>,
    /// Of every random number.
    pub seed: u64,
    /// How many of the samples, from the first on, finite differences take; 0: all.
    pub difference_samples: u32,
    /// The same of derivatives that are carried along the paths.
    pub forward_samples: u32,
}

impl From<&Task> for wire::Task {
    fn from(task: &Task) -> Self {
        let Tile { x, y, width, height } = task.tile;
        let all = task.pixels.count() == task.tile.len();
        Self {
            id: Some(task.id.into()),
            photo: u32::try_from(task.photo).unwrap_or(u32::MAX),
            tile: Some(wire::Tile { x_pixels: x, y_pixels: y, width_pixels: width, height_pixels: height }),
            pixels: if all { Bytes::new() } else { Bytes::copy_from_slice(task.pixels.as_bytes()) },
            first_sample: task.samples.start,
            end_sample: task.samples.end,
            seed: task.seed,
            difference_samples: task.difference_samples,
            forward_samples: task.forward_samples,
        }
    }
}

impl TryFrom<wire::Task> for Task {
    type Error = WireError;

    fn try_from(task: wire::Task) -> Result<Self> {
        let tile = required("Task.tile", task.tile)?;
        let tile = Tile { x: tile.x_pixels, y: tile.y_pixels, width: tile.width_pixels, height: tile.height_pixels };
        let side = |length: u32| (1..=LARGEST_TILE).contains(&length);
        let inside = |start: u32| start < gonio_scene::MAX_SIDE;
        if !(side(tile.width) && side(tile.height) && inside(tile.x) && inside(tile.y)) {
            return Err(WireError::new(
                "Task.tile",
                format!("is {tile:?}, its sides must be 1 to {LARGEST_TILE} pixels"),
            ));
        }
        let pixels = if task.pixels.is_empty() {
            PixelSet::from_flags(std::iter::repeat_n(true, tile.len()))
        } else {
            PixelSet::from_bytes(&task.pixels, tile.len()).ok_or_else(|| {
                let problem = format!("has {} bytes for {} pixels", task.pixels.len(), tile.len());
                WireError::new("Task.pixels", problem)
            })?
        };
        if pixels.count() == 0 {
            return Err(WireError::new("Task.pixels", "wants no pixel"));
        }
        // Films are as large as what is wanted, whatever the tile.
        super::at_most("Task.pixels", pixels.count(), (TILE * TILE) as usize)?;
        if task.first_sample > task.end_sample || task.end_sample > limits::SAMPLES {
            let problem =
                format!("are {}..{}, must ascend to at most {}", task.first_sample, task.end_sample, limits::SAMPLES);
            return Err(WireError::new("Task samples", problem));
        }
        for (field, samples) in
            [("Task.difference_samples", task.difference_samples), ("Task.forward_samples", task.forward_samples)]
        {
            if samples > task.end_sample - task.first_sample {
                return Err(WireError::new(field, format!("is {samples}, more than the task's samples")));
            }
        }
        Ok(Self {
            id: AttemptId::from_wire("Task.id", task.id)?,
            photo: task.photo as usize,
            tile,
            pixels,
            samples: task.first_sample..task.end_sample,
            seed: task.seed,
            difference_samples: task.difference_samples,
            forward_samples: task.forward_samples,
        })
    }
}
