//! The pages in a real browser: what they show is what is written, they survive what they watch, nothing fails on them.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

#[path = "page/farm.rs"]
mod farm;
#[path = "page/run.rs"]
mod run;
