//! Parameter sweeps: which frames a `SWEEP.toml` asks for, what each is called by its content, and the table and contact
//! sheet of the finished ones. `FORMAT.md` beside this crate lists the keys.
//!
//! Pure: a capture and texts go in; frames, digests and files' bytes come out. Who renders and where results lie is for
//! the command line.

mod design;
mod digest;
mod fitted;
mod keys;
mod listed;
mod outputs;
mod plan;
mod points;
mod record;
mod resolution;
mod sheet;
mod sweep;
mod table;
mod view;

pub use digest::FrameDigest;
pub use listed::Listed;
pub use outputs::Output;
pub use plan::{Batch, Frame, Label, Plan};
pub use record::Record;
pub use sheet::Sheet;
pub use sheet::thumbnail::Thumbnail;
pub use sweep::{Combine, Seeds, Sweep};
pub use table::Table;

/// Most frames of a sweep, and points of a design: a plan holds all of them in memory.
pub const MOST_FRAMES: u64 = 1_000_000;

/// Most photos of an extended capture, views included: the farm's limit.
pub const MOST_PHOTOS: u64 = 10_000;

/// A number in 0..1: a dimension of an Owen-scrambled Sobol sequence (Burley 2020).
fn design_unit(index: u64, dimension: u32, seed: u32) -> f64 {
    f64::from(sobol_burley::sample(index as u32, dimension, seed))
}
