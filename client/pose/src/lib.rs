//! Poses of objects: the files of the BOP benchmark (Hodan et al. 2018), its pose errors, and what recall a list of
//! estimates reaches.
//!
//! Lengths are metres everywhere but in files: `bop` converts. A pose takes a model's coordinates to the camera's, which
//! has OpenCV's axes: x right, y down, z forward.

pub mod bop;
pub mod errors;
pub mod evaluate;
mod pose;
pub mod predict;
pub mod render;

pub use pose::{Intrinsics, Pose};
