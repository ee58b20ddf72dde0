//! Reduction in fixed order: films of tasks become films of tiles, statistics of tiles, statistics of photos.
//!
//! Tasks arrive in any order, from any worker; the bits of the result never depend on it. Chunks of a tile are merged in
//! ascending order of samples, pixels of a tile in row order, tiles of a photo in row order. What arrives early waits.

pub mod gram;
mod limit;
pub mod measured;
pub mod merge;
mod partner;
pub mod prediction;
pub mod recipe;
pub mod reduction;
pub mod statistics;
mod window;

pub use measured::Measured;
pub use recipe::Recipe;
pub use reduction::Reduction;
