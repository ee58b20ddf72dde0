//! The `gonio` binary as its users meet it: files in, files and exit codes out.

// Clippy lets tests unwrap, but not the functions that they share.
#![allow(clippy::unwrap_used)]
// A fixture's ball may differ in its last bits from machine to machine.
#![allow(clippy::disallowed_methods)]

mod align;
mod board;
mod bop;
mod broken;
mod browser;
mod check;
mod devtools;
mod dprime;
mod export;
mod exposures;
mod fit;
mod fixture;
mod hdr;
mod imports;
mod interrupt;
mod matte;
mod noise;
mod page;
mod raw;
mod render;
mod study;
mod sweep;
