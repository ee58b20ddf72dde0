//! Maps: vertex colours, textures, several materials in one mesh; against what light must be, differences and single paths.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, clippy::cast_precision_loss)]

mod analytic;
mod derivatives;
mod fixture;
mod parts;
