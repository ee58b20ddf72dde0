//! `gonio sweep`.

use crate::fixture::{TRUTH, capture_file, command, edit, gonio, json, scene, succeeds};
use std::collections::BTreeMap;
use std::path::Path;
use tempfile::TempDir;

const SWEEP: &str = r#"format = 1
capture = "capture"
samples = 8
seed = 3
outputs = ["exr", "png", "buffers"]
photos = ["01"]

[[design]]
kind = "grid"
axes = [
    { name = "material.shell.roughness", from = 0.1, to = 0.7, count = 4 },
    { name = "light.led.intensity", values = [0.2, [0.1, 0.2, 0.3]] },
]

[[view]]
name = "top"
kind = "look-at"
position = [0.0, 0.0, 0.4]
target = [0.0, 0.0, 0.05]
"#;

/// What a sweep tells of itself, in files that every run of it writes alike.
const SAME: [&str; 4] = ["table.csv", "table.parquet", "sheet.png", "sheet.html"];

fn swept(text: &str) -> TempDir {
    let top = scene(TRUTH);
    std::fs::write(top.path().join("sweep.toml"), text).unwrap();
    top
}

fn run(top: &TempDir, out: &str, more: &[&str]) -> serde_json::Value {
    json(&succeeds(top.path(), &[&["sweep", "sweep.toml", "--out", out, "--json"], more].concat()))
}

fn read(top: &TempDir, path: &str) -> Vec<u8> {
    std::fs::read(top.path().join(path)).unwrap()
}

/// The rows of a table by column name.
fn rows(top: &TempDir, path: &str) -> Vec<BTreeMap<String, String>> {
    let text = String::from_utf8(read(top, path)).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = lines.next().unwrap();
    lines.map(|cells| header.iter().cloned().zip(cells).collect()).collect()
}

#[test]
fn a_frame_is_what_a_render_of_the_edited_capture_is() {
    let top = swept(SWEEP);
    let result = run(&top, "out", &[]);
    assert_eq!((&result["points"], &result["frames"], &result["rendered"]), (&8.into(), &16.into(), &16.into()));
    let rows = rows(&top, "out/table.csv");
    // Point 5: roughness 0.5, the coloured lamp.
    let row = &rows[10];
    assert_eq!((row["point"].as_str(), row["view"].as_str()), ("5", "01"));
    edit(&capture_file(&top), "roughness = 0.35", &format!("roughness = {}", row["material.shell.roughness"]));
    edit(&capture_file(&top), "intensity = [0.3, 0.3, 0.3]", "intensity = [0.1, 0.2, 0.3]");
    let arguments =
        ["render", "capture", "--out", "one", "--photos", "01", "--samples", "8", "--seed", "3", "--buffers"];
    let told = json(&succeeds(top.path(), &[&arguments[..], &["--json"]].concat()));
    assert!(read(&top, &format!("out/{}", row["exr"])) == read(&top, "one/01.exr"));
    assert!(read(&top, &format!("out/{}", row["buffers"])) == read(&top, "one/01.buffers.exr"));
    assert_eq!(told["photos"][0]["mean"][1].as_f64().unwrap(), row["mean.g"].parse::<f64>().unwrap());
    // The extended capture renders its views from where it lies.
    let extended = ["render", "out", "--out", "two", "--photos", "top", "--samples", "2"];
    succeeds(top.path(), &extended);
}

#[test]
fn what_is_there_is_not_rendered_again() {
    let top = swept(SWEEP);
    run(&top, "whole", &["--threads", "1"]);
    let dry = run(&top, "out", &["--dry-run"]);
    assert!(!top.path().join("out").exists());
    assert_eq!((&dry["finished_before"], &dry["frames"]), (&0.into(), &16.into()));
    assert!(dry["estimated_seconds"].as_f64().unwrap() > 0.0);
    assert_eq!(dry["bytes_at_most"], 16 * 32 * 24 * (12 + 3 + 40));

    // Half of the sweep first, under another file's name; then all of it.
    let half = SWEEP.replace("from = 0.1, to = 0.7, count = 4", "values = [0.1, 0.7]");
    std::fs::write(top.path().join("half.toml"), half).unwrap();
    json(&succeeds(top.path(), &["sweep", "half.toml", "--out", "out", "--json"]));
    // A frame whose record was cut off, one without a file, and one with an empty file, are not finished.
    let frames = rows(&top, "out/table.csv");
    let out = top.path().join("out");
    std::fs::write(out.join(frames[0]["exr"].replace(".exr", ".json")), "{\"digest\":\"").unwrap();
    std::fs::remove_file(out.join(&frames[1]["png"])).unwrap();
    std::fs::write(out.join(&frames[2]["buffers"]), "").unwrap();
    let result = run(&top, "out", &["--threads", "2", "--in-flight", "3"]);
    assert_eq!((&result["finished_before"], &result["rendered"]), (&5.into(), &11.into()));
    for name in SAME {
        assert!(read(&top, &format!("out/{name}")) == read(&top, &format!("whole/{name}")), "{name}");
    }
    // Measured once, kept since.
    let timings = read(&top, "out/timings.csv");
    let again = run(&top, "out", &[]);
    assert_eq!((&again["finished_before"], &again["rendered"]), (&16.into(), &0.into()));
    assert!(timings == read(&top, "out/timings.csv"));
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_frames_and_the_same_command_goes_on() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    let long = SWEEP.replace("count = 4", "count = 60").replace("samples = 8", "samples = 128");
    let top = swept(&long);
    let arguments = ["sweep", "sweep.toml", "--out", "out", "--threads", "1", "--in-flight", "2"];
    let child = command(top.path(), &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let records = || walk(&top.path().join("out/frames")).into_iter().filter(|name| name.ends_with(".json")).count();
    let patience = Instant::now();
    while records() < 10 {
        assert!(patience.elapsed() < Duration::from_secs(120), "no frames");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    let kept = records();
    assert!(stderr.contains(&format!("interrupted: {kept} of 240 frames")), "{stderr}");
    assert!(!top.path().join("out/table.csv").exists());

    let result = run(&top, "out", &[]);
    assert_eq!((&result["finished_before"], &result["rendered"]), (&kept.into(), &(240 - kept).into()));
    run(&top, "whole", &[]);
    for name in SAME {
        assert!(read(&top, &format!("out/{name}")) == read(&top, &format!("whole/{name}")), "{name}");
    }
}

fn walk(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.path().is_dir() {
            names.extend(walk(&entry.path()));
        } else {
            names.push(entry.file_name().into_string().unwrap());
        }
    }
    names
}

#[test]
fn frames_that_show_the_same_are_rendered_once() {
    let top = swept(
        "format = 1\ncapture = \"capture\"\nsamples = 2\n[[design]]\nkind = \"grid\"\naxes = [{ name = \"photo.02.gain\", values = [1, 2, 3] }]\n",
    );
    let result = run(&top, "out", &[]);
    assert_eq!((&result["frames"], &result["rendered"]), (&12.into(), &6.into()));
    let rows = rows(&top, "out/table.csv");
    assert_eq!((&rows[0]["exr"], &rows[0]["mean.r"]), (&rows[4]["exr"], &rows[8]["mean.r"]));
    let mean = |row: usize| rows[row]["mean.r"].parse::<f64>().unwrap();
    assert!((mean(10) / mean(2) - 3.0).abs() < 1e-6);
}

#[test]
fn samples_without_a_value_are_counted_for_their_own_frame() {
    let top = crate::fixture::blinded(swept("format = 1\ncapture = \"capture\"\nsamples = 4\n"));
    run(&top, "out", &[]);
    let rows = rows(&top, "out/table.csv");
    let invalid: Vec<u64> = rows.iter().map(|row| row["invalid_samples"].parse().unwrap()).collect();
    assert!(invalid[0] == 0 && invalid[2] == 0 && invalid[1] > 0 && invalid[3] > 0, "{invalid:?}");
}

#[test]
fn mistakes_name_file_and_key() {
    let top = swept(SWEEP);
    let cases: [(&str, &str, &[&str]); 5] = [
        ("to = 0.7", "to = 1.7", &["sweep.toml: design[0].axes[0].to", "1.7", "0..=1"]),
        ("light.led.intensity", "light.lid.intensity", &["sweep.toml: design[0].axes[1].name", "light.lid.intensity"]),
        ("samples = 8", "sample = 8", &["sweep.toml: sample", "did you mean `samples`"]),
        ("capture = \"capture\"", "capture = \"nowhere\"", &["nowhere", "does not exist"]),
        ("photos = [\"01\"]", "photos = [\"9\"]", &["sweep.toml: photos", "00, 01"]),
    ];
    for (from, to, expected) in cases {
        std::fs::write(top.path().join("sweep.toml"), SWEEP.replace(from, to)).unwrap();
        let output = gonio(top.path(), &["sweep", "sweep.toml", "--out", "out"]);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(expected.iter().all(|part| stderr.contains(part)) && stderr.lines().count() == 1, "{stderr}");
    }
    std::fs::write(top.path().join("sweep.toml"), SWEEP).unwrap();
    for (out, expected) in
        [("ftp://host/x", "unknown kind"), ("memory://", "end with this process"), ("capture", "capture itself")]
    {
        let output = gonio(top.path(), &["sweep", "sweep.toml", "--out", out]);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains("--out") && stderr.contains(expected), "{stderr}");
    }
}
