//! A design of observations: which pixels of large photos a fit compares, chosen before the fit by what lies behind them.
//!
//! Pure: a capture and what its cameras' rays hit first, at a low resolution, go in; the probability of every pixel comes out, as
//! [`gonio_scene::design::Design`]. The same capture, seed and number give the same bits, whoever renders.

mod allocate;
mod choose;
mod preview;
mod strata;

pub use choose::{ALL_UP_TO, CELLS, MANY, choose, pixels};
pub use preview::{Preview, preview, shrink};
