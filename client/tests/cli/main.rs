//! The `gonio` binary as its users meet it: files in, files and exit codes out.

// Clippy lets tests unwrap, but not the functions that they share.
#![allow(clippy::unwrap_used)]

mod broken;
mod check;
mod fit;
mod fixture;
mod interrupt;
mod render;
