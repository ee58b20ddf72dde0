//! How far an estimated pose is from the true one, by the benchmark's measures.

mod distance;
mod vsd;

pub use distance::{Shape, rotation, translation};
pub use vsd::{DELTA, TAUS, vsd};
