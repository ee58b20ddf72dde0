//! Exports as others read them: structure, what is lost, bad input; and the real programs where they are.

// Clippy lets tests unwrap, but not the functions that they share.
#![allow(clippy::unwrap_used)]

mod bad;
mod blender;
mod fixture;
mod gltf;
mod ledger;
mod mitsuba;
mod painted;
mod pbrt;
mod programs;
mod sensor;
mod usd;
