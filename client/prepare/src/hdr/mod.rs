//! Radiance maps from stacks of exposures, after Debevec and Malik, "Recovering high dynamic range radiance maps from
//! photographs", SIGGRAPH 1997.

pub mod align;
mod exif;
mod filled;
mod ghost;
mod merge;
mod orient;
mod patches;
mod plot;
mod preview;
mod region;
mod response;
mod solve;
mod stack;
mod suspect;

pub use exif::exposure;
pub use filled::fill_below;
pub use merge::{Mark, Merged, merge};
pub use orient::{Orientation, orient};
pub use plot::plot;
pub use preview::preview;
pub use region::Region;
pub use response::{LEVELS, Response};
pub use solve::calibrate;
pub use stack::{Shot, Stack};
pub use suspect::{Suspect, correct_times};
