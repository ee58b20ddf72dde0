//! Readers of what others have written, over damaged files and messages: each ends in a value or an error, never in a panic, and
//! takes no more memory than its limit, whatever sizes the damage announces.
//!
//! A few seconds by default, the same cases in every run. `GONIO_FUZZ_SECONDS=600 cargo test --release -p gonio-tests
//! --test fuzz -- --test-threads 1` goes on for so long with each reader; a failure names its case, and `GONIO_FUZZ_FROM`
//! starts there.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

mod damage;
mod targets;

use damage::damaged;
use peak_alloc::PeakAlloc;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Held by the reader that is measured.
static TURN: Mutex<()> = Mutex::new(());

/// Cases of a short run.
const CASES: u64 = 1500;

/// A reader with files that it takes.
struct Target {
    name: &'static str,
    /// What is damaged; all of it is read without an error.
    good: Vec<Vec<u8>>,
    /// Reads one of the files: which one, and its bytes, damaged. Returns whether it was taken.
    read: fn(usize, &[u8]) -> bool,
    /// Most memory that one reading may take, bytes.
    memory: usize,
}

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().unwrap_or_else(|_| panic!("{name}: write a whole number")))
}

fn survives(target: &Target) {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    for (which, good) in target.good.iter().enumerate() {
        assert!((target.read)(which, good), "{}: file {which} is not taken unchanged", target.name);
    }
    let (from, seconds) = (number("GONIO_FUZZ_FROM").unwrap_or(0), number("GONIO_FUZZ_SECONDS"));
    let begin = Instant::now();
    let (mut case, mut taken) = (from, 0_u64);
    let more = |case: u64| match seconds {
        Some(seconds) => begin.elapsed() < Duration::from_secs(seconds),
        None => case < from + CASES,
    };
    while more(case) {
        let (which, bytes) = damaged(&target.good, case);
        let before = MEMORY.current_usage();
        MEMORY.reset_peak_usage();
        let read = catch_unwind(AssertUnwindSafe(|| (target.read)(which, &bytes)));
        let peak = MEMORY.peak_usage().saturating_sub(before);
        assert!(peak <= target.memory, "{}: case {case} of file {which} takes {peak} bytes", target.name);
        match read {
            Ok(good) => taken += u64::from(good),
            Err(_) => panic!("{}: case {case} of file {which} panics", target.name),
        }
        case += 1;
    }
    let cases = case - from;
    println!("{}: {cases} cases, {taken} taken, in {:.0} s", target.name, begin.elapsed().as_secs_f64());
    // Damage that is always found, or never, would test nothing.
    assert!(taken > 0 && taken < cases);
}

#[test]
fn captures() {
    survives(&targets::capture());
}

#[test]
fn meshes() {
    survives(&targets::mesh());
}

#[test]
fn images() {
    survives(&targets::image());
}

#[test]
fn raw() {
    survives(&targets::raw(number("GONIO_FUZZ_SECONDS").is_some()));
}

#[test]
fn sweeps() {
    survives(&targets::sweep());
}

#[test]
fn messages() {
    survives(&targets::message());
}

#[test]
fn reflectance() {
    survives(&targets::reflectance());
}
