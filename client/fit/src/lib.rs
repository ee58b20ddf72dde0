//! Fits the free parameters of a capture by analysis-by-synthesis, over anything that implements [`Evaluate`].

pub mod evaluate;

pub use evaluate::{Evaluate, EvaluateError, Watch};
