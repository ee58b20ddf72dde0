//! Sweeps from their text to their frames: what the format says, what it refuses, what a frame is called.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

mod broken;
mod designs;
mod digests;
mod example;
mod fixture;
mod mutations;
mod views;
