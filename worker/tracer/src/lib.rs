//! The path tracer: a pure library from (capture, numbers, tile, sample range, seed) to films and derivative images.
//!
//! Equal input gives equal bits on every machine: random numbers are counted, not drawn from state; SIMD and portable
//! paths decide hits by the same arithmetic; transcendental functions come from the `libm` crate.

// Pixel coordinates, counts and indices are far below 2^24; physical numbers lose digits on purpose when they enter the
// tracer's single precision.
#![allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]

mod affine;
mod basis;
mod batch;
pub mod bsdf;
pub mod bvh;
mod camera;
mod difference;
mod extent;
mod geometry;
mod integrator;
mod light;
mod paint;
mod planes;
mod prepared;
mod reflectance;
mod render;
mod sampler;
mod scene;
mod shader;
mod surface_basis;
mod vectors;

pub use prepared::{Prepared, Stage};
pub use render::TileTask;
pub use shader::AIR;
