//! A camera's colours from a photograph of a chart of 24 patches: the 3x3 matrix to Rec. 709 under which the patches come
//! nearest to their published colours.

mod difference;
mod fit;
mod patches;
mod reference;

pub use difference::{ciede2000, lab_of};
pub use fit::{Found, Patch, fit};
pub use patches::{Corners, Seen, see};
pub use reference::{Edition, NAMES};
