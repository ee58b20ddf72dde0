//! The `gonio` binary as its users meet it: files in, files and exit codes out.

mod broken;
mod check;
mod fit;
mod fixture;
mod interrupt;
mod render;
