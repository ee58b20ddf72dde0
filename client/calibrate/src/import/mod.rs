//! Poses that others estimated, in the conventions of the capture format.

mod bop;
mod colmap;
mod transforms;

pub use bop::bop;
pub use colmap::colmap;
pub use transforms::transforms;
