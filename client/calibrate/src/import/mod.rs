//! Poses that others estimated, in the conventions of the capture format.

mod bop;
mod colmap;
mod transforms;

pub use bop::bop;
pub use colmap::{colmap, colmap_binary};
pub use transforms::transforms;
