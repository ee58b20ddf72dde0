//! Rating studies: can people tell rendered images from photographs, and by how much?
//!
//! Pure: texts and counts go in, numbers, a plot and the bytes of a page come out. The server and the files are the
//! command line's.

mod detection;
mod error;
mod interval;
mod log;
mod normal;
mod order;
pub mod page;
mod plot;
mod ratings;
mod roc;
mod summary;

pub use detection::{Detection, miller_variance};
pub use error::StudyError;
pub use interval::Estimate;
pub use log::{HEADER, line, whole_lines};
pub use order::order;
pub use plot::plot;
pub use ratings::{Rating, Ratings, Truth};
pub use roc::{Counts, Roc};
pub use summary::{ImageRow, ObserverRow, Options, Summary};

/// Levels of the scale: 1 is "definitely real", 5 is "definitely synthetic".
pub const LEVELS: usize = 5;
