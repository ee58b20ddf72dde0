//! `gonio fit`.

use crate::fixture::{TRUTH, blinded, capture_file, edit, gonio, json, photographed, succeeds};
use serde_json::Value;
use std::path::Path;

fn value(result: &Value, name: &str) -> (f64, f64) {
    let found = result["parameters"].as_array().unwrap().iter().find(|p| p["name"] == name).unwrap();
    (found["value"].as_f64().unwrap(), found["standard_error"].as_f64().unwrap())
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The photographs come from the same renderer, with another seed and so many samples that little of their noise is left;
/// they have none of the sensor's.
#[test]
fn recovers_the_truth_and_writes_a_capture_that_works_from_elsewhere() {
    let top = photographed(2048);
    let stdout = succeeds(top.path(), &["fit", "capture", "--out", "deep/out", "--json"]);
    let out = top.path().join("deep/out");
    let result = read(&out.join("fit.json"));
    assert_eq!(json(&stdout), result);
    assert_eq!(result["converged"], true, "{result:#}");
    let truths = [
        ("material.shell.base_color.r", TRUTH.color[0]),
        ("material.shell.base_color.g", TRUTH.color[1]),
        ("material.shell.base_color.b", TRUTH.color[2]),
        ("material.shell.roughness", TRUTH.roughness),
        ("light.led.intensity", TRUTH.intensity),
    ];
    for (name, truth) in truths {
        let (value, error) = value(&result, name);
        assert!((value - truth).abs() < (3.0 * error).max(0.003 * truth), "{name}: {value} ± {error}, not {truth}");
        assert!(error < 0.05 * truth, "{name} ± {error}");
    }
    assert!(result["held_out"]["reduced_chi_square"].as_f64().unwrap() < 1.05);
    assert_eq!(result["correlations"].as_array().unwrap().len(), 5);

    // From another working directory, by either name.
    let elsewhere = tempfile::tempdir().unwrap();
    let check = succeeds(elsewhere.path(), &["check", out.to_str().unwrap(), "--json"]);
    let check = json(&check);
    assert_eq!((&check["valid"], &check["errors"]), (&Value::Bool(true), &Value::Array(vec![])));
    let fitted = out.join("capture.toml");
    succeeds(elsewhere.path(), &["render", fitted.to_str().unwrap(), "--out", "r", "--samples", "2", "--photos", "03"]);
    // A fit's result is a fit's input.
    let again = succeeds(elsewhere.path(), &["fit", fitted.to_str().unwrap(), "--out", "again", "--json"]);
    let (before, error) = value(&result, "material.shell.roughness");
    assert!((value(&json(&again), "material.shell.roughness").0 - before).abs() < error);
}

#[test]
fn the_report_shows_every_photo() {
    let top = photographed(16);
    succeeds(top.path(), &["fit", "capture", "--out", "out"]);
    let page = std::fs::read_to_string(top.path().join("out/report.html")).unwrap();
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 4 * 3);
    assert_eq!(page.matches("<span class=\"badge\">held out</span>").count(), 1);
    for part in ["material.shell.roughness", "<svg class=\"chart\"", "class=\"matrix\"", "--out out", "converged"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("http://") && !page.contains("https://"));
}

#[test]
fn resuming_ends_with_the_bits_of_a_fit_without_a_break() {
    let top = photographed(16);
    let fit = |out: &str, more: &[&str]| {
        succeeds(top.path(), &[&["fit", "capture", "--json", "--out", out], more].concat());
        read(&top.path().join(out).join("fit.json"))
    };
    let whole = fit("whole", &[]);
    let short = fit("short", &["--max-iterations", "2"]);
    assert_eq!(short["converged"], false);
    assert!(short["warnings"][0].as_str().unwrap().contains("not converged"));
    let resumed = fit("short", &["--resume"]);
    for key in ["parameters", "fit", "held_out", "correlations", "loss_curve", "iterations", "primary_samples"] {
        assert_eq!(resumed[key], whole[key], "{key}");
    }
}

#[test]
fn a_checkpoint_continues_nothing_else() {
    let top = photographed(16);
    let short = ["fit", "capture", "--max-iterations", "1"];
    succeeds(top.path(), &[&short[..], &["--out", "out"]].concat());
    let refused_in = |out: &str, more: &[&str], what: &str| {
        let output = gonio(top.path(), &[&short[..], &["--resume", "--out", out], more].concat());
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(what), "{what}: {stderr}");
    };
    let refused = |more: &[&str], what: &str| refused_in("out", more, what);
    refused(&["--seed", "3"], "seed");
    refused(&["--solver", "l-bfgs"], "solver");
    refused(&["--start", "material.shell.roughness=0.3"], "start");
    refused_in("nowhere", &[], "checkpoint.json");
    // Other bytes under an old name: a mesh, a photograph.
    for (file, other) in [("board.ply", "ball.ply"), ("photos/01.exr", "photos/02.exr")] {
        let [file_path, other] = [file, other].map(|name| top.path().join("capture").join(name));
        let kept = std::fs::read(&file_path).unwrap();
        std::fs::copy(other, &file_path).unwrap();
        refused(&[], &format!("{file}: is not what it was"));
        refused(&[], "start anew without --resume");
        std::fs::write(&file_path, kept).unwrap();
    }
    succeeds(top.path(), &[&short[..], &["--resume", "--out", "out"]].concat());
    edit(&capture_file(&top), "ior = 1.5", "ior = 1.6");
    refused(&[], "capture");
}

#[test]
fn what_is_free_and_where_it_starts_can_be_told() {
    let top = photographed(16);
    let arguments = ["fit", "capture", "--out", "out", "--json", "--max-iterations", "1", "--samples", "2"];
    let more = ["--free", "material.shell.roughness,material.shell.ior", "--start", "material.shell.ior=1.4"];
    let result = json(&succeeds(top.path(), &[&arguments[..], &more].concat()));
    let names: Vec<&str> =
        result["parameters"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["material.shell.roughness", "material.shell.ior"]);
    assert_eq!(result["parameters"][1]["start"], 1.4);
    let fitted = std::fs::read_to_string(top.path().join("out/capture.toml")).unwrap();
    assert!(fitted.contains("material.shell.ior") && !fitted.contains("gray"), "{fitted}");
}

#[test]
fn events_are_json_lines() {
    let top = photographed(16);
    let output = gonio(top.path(), &["fit", "capture", "--out", "out", "--json", "--solver", "gauss-newton"]);
    assert_eq!(output.status.code(), Some(0));
    let events: Vec<Value> =
        String::from_utf8(output.stderr).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of = |kind: &str| events.iter().filter(|event| event["event"] == kind).count();
    assert_eq!((of("started"), of("held_out"), of("finished")), (1, 1, 1));
    assert!(of("iteration_done") >= 2, "{events:?}");
}

#[test]
fn samples_that_overflow_are_counted_and_told() {
    let top = blinded(photographed(4));
    let result = json(&succeeds(
        top.path(),
        &["fit", "capture", "--out", "out", "--json", "--max-iterations", "2", "--samples", "4"],
    ));
    let warnings: Vec<&str> = result["warnings"].as_array().unwrap().iter().map(|w| w.as_str().unwrap()).collect();
    for which in ["fitted", "held-out"] {
        let expected = format!("samples of the {which} photos were NaN or infinite and count as black");
        assert!(warnings.iter().any(|warning| warning.contains(&expected)), "{warnings:?}");
    }
    let report = std::fs::read_to_string(top.path().join("out/report.html")).unwrap();
    assert!(report.contains("were NaN or infinite"));
}
