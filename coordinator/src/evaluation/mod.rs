//! One client's evaluation: read what it needs, split it, watch it, stream its answer.

mod cache;
mod prepare;
mod run;
mod stream;

pub use cache::Captures;
pub use prepare::{Asked, Prepared, prepare};
pub use run::evaluate;
pub(crate) use run::resume;
pub use stream::progress;
