//! Light, geometry and camera effects against formulas, against other ways to build the same scene, and at the values
//! where they must change nothing; and derivatives by differences against whole renders.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

mod blocks;
mod camera;
mod differences;
mod fixture;
mod lights;
mod objects;
mod translucency;
