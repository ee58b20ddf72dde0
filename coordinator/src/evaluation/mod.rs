//! One client's evaluation: read what it needs, split it, watch it, stream its answer.

mod cache;
mod prepare;
mod stream;

pub use cache::Captures;
pub use prepare::{Prepared, prepare};
pub use stream::evaluate;
