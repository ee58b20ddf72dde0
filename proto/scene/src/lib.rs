//! Domain types of Gonio: what a capture is, how its numbers are named, what an evaluation asks and answers.
//!
//! No I/O beyond reading a capture's files, no transport, no rendering. Everything else of the workspace depends on
//! this crate and this crate on nothing of it.

pub mod assets;
pub mod capture;
mod decoder;
pub mod derivative;
pub mod design;
pub mod error;
pub mod evaluation;
pub mod files;
pub mod film;
pub mod image;
pub mod mesh;
pub mod parameter;
pub mod reflectance;
pub mod sensor_stage;
pub mod statistics;
pub mod stream;
pub mod surroundings;
pub mod textures;

pub use assets::{Assets, Photograph, Values};
pub use capture::Capture;
pub use decoder::shielded;
pub use error::{Result, SceneError};
pub use evaluation::{Evaluation, EvaluationRequest, Film, Output, Progress};
pub use parameter::{Parameter, Term};
pub use sensor_stage::{PhotoValue, SensorStage};
pub use statistics::PhotoStatistics;
pub use stream::Stream;

/// The largest width or height of an image in pixels.
pub const MAX_SIDE: u32 = 16384;
