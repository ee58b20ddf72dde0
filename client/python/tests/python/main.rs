//! The Python package as its users meet it.
//!
//! Needs a Python of 3.10 or later with numpy; where there is none, every test says so and is skipped. `GONIO_PYTHON` names one that
//! has the wheel installed, which is tested then; else `python3` gets the library of this build and the Python files beside it.

// Clippy lets tests unwrap, but not the functions that they share.
#![allow(clippy::unwrap_used)]

mod arrays;
mod book;
mod command;
mod examples;
mod interpreter;
mod threads;
mod types;
