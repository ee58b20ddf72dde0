//! The book's listings run as they stand: those of the shell here, those of Python beside the Python package.
//!
//! A listing that begins with "```sh" is run; "```sh own-part" needs the photographs of a part that are not part of the project, and is
//! skipped where they are absent; "```sh ignore" is not run, and its chapter says below why.

// Clippy lets tests unwrap, but not the functions that they share.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Chapters with listings that are not run, and why.
const IGNORED: [(&str, &str); 3] = [
    (
        "farm.md",
        "certificates, ports and containers; the tests of the cluster, of security and of compose run the same programs",
    ),
    ("photographs.md", "photographs that are not part of the project; the tests of each command make their own"),
    ("predict.md", "ten minutes; the tests of the pose commands run each on fewer images"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// A chapter's listings whose fence says `info`, in order.
fn listings(chapter: &str, info: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join("client/book/src").join(chapter)).unwrap();
    let fence = format!("```{info}\n");
    let mut found = Vec::new();
    let mut rest = text.as_str();
    while let Some(at) = rest.find(&fence) {
        let body = &rest[at + fence.len()..];
        let end = body.find("\n```").unwrap();
        found.push(body[..=end].to_owned());
        rest = &body[end + 4..];
    }
    found
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &to);
        } else {
            std::fs::write(to, std::fs::read(path).unwrap()).unwrap();
        }
    }
}

/// A folder that holds of the repository what the listings name.
fn repository() -> TempDir {
    let top = tempfile::tempdir().unwrap();
    for part in ["tests/captures/none-201", "tests/captures/vignetting-204", "client/sweep/example"] {
        copy(&root().join(part), &top.path().join(part));
    }
    top
}

/// Runs listings one after another in a folder, as a shell would; gives what they print.
fn run(at: &Path, listings: &[String]) -> String {
    let gonio = Path::new(env!("CARGO_BIN_EXE_gonio"));
    let path = format!("{}:{}", gonio.parent().unwrap().display(), std::env::var("PATH").unwrap());
    let script = listings.concat();
    let output = Command::new("sh").args(["-e", "-c", &script]).current_dir(at).env("PATH", path).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{script}\n{stderr}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_chapter_is_listed_and_says_how_its_listings_are_meant() {
    let folder = root().join("client/book/src");
    let summary = std::fs::read_to_string(folder.join("SUMMARY.md")).unwrap();
    let listed: BTreeSet<&str> =
        summary.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(file, _)| file).collect();
    let ignored: BTreeSet<&str> = IGNORED.iter().map(|(chapter, _)| *chapter).collect();
    for entry in std::fs::read_dir(&folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name == "SUMMARY.md" {
            continue;
        }
        assert!(listed.contains(name.as_str()), "SUMMARY.md does not list {name}");
        let text = std::fs::read_to_string(folder.join(&name)).unwrap();
        let fences: Vec<&str> = text.lines().filter(|line| line.starts_with("```") && line.len() > 3).collect();
        for fence in &fences {
            let known = ["```sh", "```sh own-part", "```sh ignore", "```python", "```python ignore", "```text"];
            assert!(known.contains(fence), "{name}: {fence}");
        }
        assert_eq!(fences.contains(&"```sh ignore"), ignored.contains(name.as_str()), "{name}");
        // What it leads to is there.
        for link in text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link) {
            let file = link.split('#').next().unwrap();
            assert!(
                file.is_empty() || link.starts_with("http") || folder.join(file).exists(),
                "{name} leads to {link}"
            );
        }
    }
}

#[test]
fn a_sweep_renders_its_example() {
    let top = repository();
    run(top.path(), &listings("sweep.md", "sh"));
    assert!(top.path().join("out/sheet.html").exists());
}

#[test]
fn exports_are_written() {
    let top = repository();
    let text = run(top.path(), &listings("exports.md", "sh"));
    assert_eq!(text.lines().filter(|line| line.starts_with("exported none-201 for ")).count(), 5, "{text}");
}

#[test]
fn a_diagnosis_names_the_cause() {
    let top = repository();
    let text = run(top.path(), &listings("diagnose.md", "sh"));
    assert!(text.contains("found: vignetting"), "{text}");
}

#[test]
fn the_tutorial_leads_to_the_part() {
    let part = root().join("../shared/own-part");
    if !part.exists() {
        eprintln!("skipped: there is no {}", part.display());
        return;
    }
    let top = tempfile::tempdir().unwrap();
    copy(&part, top.path());
    let text = run(top.path(), &listings("tutorial.md", "sh own-part"));
    assert!(text.contains("valid, with 0 warnings"), "{text}");
    let fit: serde_json::Value =
        serde_json::from_slice(&std::fs::read(top.path().join("fit/fit.json")).unwrap()).unwrap();
    let value = |name: &str| {
        let found = fit["parameters"].as_array().unwrap().iter().find(|one| one["name"] == name);
        found.unwrap()["value"].as_f64().unwrap()
    };
    // What the photographs were made with.
    let truth = [("base_color.r", 0.60, 0.1), ("base_color.g", 0.22, 0.1), ("roughness", 0.35, 0.03)];
    for (name, truth, tolerance) in truth {
        let value = value(&format!("material.surface.{name}"));
        assert!((value / truth - 1.0).abs() < tolerance, "{name}: {value}, and not {truth}");
    }
}
