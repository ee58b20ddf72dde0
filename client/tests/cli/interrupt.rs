//! Ctrl-C.
#![cfg(unix)]

use crate::fixture::{command, gonio, photographed, succeeds};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A fit of thousands of evaluations.
const LONG: [&str; 6] = ["fit", "capture", "--out", "out", "--solver", "particle-swarm"];

fn evaluations(checkpoint: &Path) -> usize {
    let text = std::fs::read_to_string(checkpoint).unwrap_or_default();
    text.lines().filter(|line| line.starts_with("{\"evaluation\"")).count()
}

fn signal(child: &Child) {
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(status.success());
}

#[test]
fn keeps_what_was_reached_and_continues_from_it() {
    let top = photographed(16);
    let checkpoint = top.path().join("out/checkpoint.json");
    let child = command(top.path(), &LONG).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let patience = Instant::now();
    while evaluations(&checkpoint) < 20 {
        assert!(patience.elapsed() < Duration::from_secs(120), "no evaluations");
        std::thread::sleep(Duration::from_millis(20));
    }
    signal(&child);
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    assert!(stderr.contains("--resume"), "{stderr}");

    let result = std::fs::read_to_string(top.path().join("out/fit.json")).unwrap();
    let result: serde_json::Value = serde_json::from_str(&result).unwrap();
    assert_eq!(result["converged"], false);
    assert!(result["warnings"][0].as_str().unwrap().contains("cancelled"));
    succeeds(top.path(), &["check", "out"]);
    assert!(std::fs::read_to_string(top.path().join("out/report.html")).unwrap().contains("interrupted"));

    // What was paid for is not paid again: the checkpoint's records stay the first of the resumed fit's.
    let before = std::fs::read_to_string(&checkpoint).unwrap();
    let paid: Vec<&str> = before.lines().filter(|line| line.starts_with("{\"evaluation\"")).collect();
    let resumed = gonio(top.path(), &[&LONG[..], &["--resume", "--max-iterations", "1"]].concat());
    assert_eq!(resumed.status.code(), Some(0), "{}", String::from_utf8_lossy(&resumed.stderr));
    let after = std::fs::read_to_string(&checkpoint).unwrap();
    let kept: Vec<&str> = after.lines().filter(|line| line.starts_with("{\"evaluation\"")).take(paid.len()).collect();
    assert!(kept == paid);
}
