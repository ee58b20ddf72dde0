//! The house: which crate may depend on which, held against `cargo metadata`.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Every crate of the workspace with the crates of ours that it may depend on (tests and benchmarks included).
const MAY_DEPEND_ON: [(&str, &[&str]); 21] = [
    ("gonio-scene", &[]),
    ("gonio-proto", &["gonio-scene"]),
    ("gonio-store", &["gonio-proto"]),
    ("gonio-operations", &[]),
    ("gonio-tracer", &["gonio-scene"]),
    ("gonio-fit", &["gonio-scene"]),
    ("gonio-design", &["gonio-scene"]),
    ("gonio-diagnose", &["gonio-scene", "gonio-fit"]),
    ("gonio-sweep", &["gonio-scene", "gonio-pose"]),
    ("gonio-prepare", &["gonio-scene"]),
    ("gonio-study", &[]),
    ("gonio-calibrate", &["gonio-scene"]),
    ("gonio-pose", &["gonio-scene"]),
    ("gonio-estimate", &["gonio-scene", "gonio-pose"]),
    ("gonio-export", &["gonio-scene", "gonio-tracer"]),
    ("gonio-page", &[]),
    ("gonio-worker", &["gonio-scene", "gonio-proto", "gonio-store", "gonio-operations", "gonio-tracer"]),
    ("gonio-coordinator", &["gonio-scene", "gonio-proto", "gonio-store", "gonio-operations", "gonio-page"]),
    (
        "gonio",
        &[
            "gonio-scene",
            "gonio-proto",
            "gonio-store",
            "gonio-operations",
            "gonio-fit",
            "gonio-design",
            "gonio-diagnose",
            "gonio-sweep",
            "gonio-prepare",
            "gonio-study",
            "gonio-calibrate",
            "gonio-pose",
            "gonio-estimate",
            "gonio-export",
            "gonio-page",
            "gonio-coordinator",
            "gonio-worker",
        ],
    ),
    ("gonio-python", &["gonio", "gonio-export", "gonio-scene"]),
    (
        "gonio-tests",
        &[
            "gonio-scene",
            "gonio-proto",
            "gonio-operations",
            "gonio-tracer",
            "gonio-fit",
            "gonio-design",
            "gonio-diagnose",
            "gonio-sweep",
            "gonio-prepare",
            "gonio-worker",
            "gonio-page",
            "gonio-coordinator",
            "gonio",
        ],
    ),
];

/// Libraries that must not reach a crate, even through others: transport stays out of the domain, the tracer and the fit.
const NEVER: [(&str, &[&str]); 13] = [
    ("gonio-scene", &["tokio", "tonic", "prost"]),
    ("gonio-tracer", &["tokio", "tonic", "prost"]),
    ("gonio-fit", &["tokio", "tonic", "prost"]),
    ("gonio-design", &["tokio", "tonic", "prost"]),
    ("gonio-diagnose", &["tokio", "tonic", "prost"]),
    ("gonio-sweep", &["tokio", "tonic", "prost"]),
    ("gonio-prepare", &["tokio", "tonic", "prost"]),
    ("gonio-study", &["tokio", "tonic", "prost"]),
    ("gonio-calibrate", &["tokio", "tonic", "prost"]),
    ("gonio-pose", &["tokio", "tonic", "prost"]),
    ("gonio-estimate", &["tokio", "tonic", "prost"]),
    ("gonio-export", &["tokio", "tonic", "prost"]),
    ("gonio-page", &["tonic", "prost"]),
];

fn metadata() -> serde_json::Value {
    let out = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).unwrap()
}

#[test]
fn dependencies_point_one_way() {
    let allowed: BTreeMap<_, BTreeSet<_>> =
        MAY_DEPEND_ON.iter().map(|(name, on)| (*name, on.iter().copied().collect())).collect();
    let never: BTreeMap<_, _> = NEVER.into_iter().collect();
    let metadata = metadata();
    let packages = metadata["packages"].as_array().unwrap();
    assert_eq!(packages.len(), MAY_DEPEND_ON.len(), "a crate joined or left the house: say here what it may depend on");
    for package in packages {
        let name = package["name"].as_str().unwrap();
        let may = allowed.get(name).unwrap_or_else(|| panic!("{name} is not in the list"));
        for dependency in package["dependencies"].as_array().unwrap() {
            let on = dependency["name"].as_str().unwrap();
            if on.starts_with("gonio") {
                assert!(may.contains(on), "{name} may not depend on {on}");
            }
            let banned = never.get(name).is_some_and(|list| list.contains(&on));
            assert!(!banned, "{name} may not depend on {on}");
        }
    }
}

#[test]
fn every_crate_takes_the_workspace_lints() {
    for package in metadata()["packages"].as_array().unwrap() {
        let manifest = std::fs::read_to_string(package["manifest_path"].as_str().unwrap()).unwrap();
        let lints = manifest.split("[lints]").nth(1).unwrap_or_default().trim_start();
        assert!(lints.starts_with("workspace = true"), "{} has lints of its own", package["name"]);
    }
}
