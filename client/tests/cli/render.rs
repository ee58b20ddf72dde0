//! `gonio render`.

use crate::fixture::{SIZE, TRUTH, blinded, edit, gonio, json, refused, scene, succeeds};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image;

#[test]
fn writes_films_of_the_right_size_without_photographs() {
    let top = scene(TRUTH);
    let stdout = succeeds(top.path(), &["render", "capture/capture.toml", "--out", "out", "--samples", "16", "--json"]);
    let result = json(&stdout);
    assert_eq!(result["primary_samples"], u64::from(SIZE.0 * SIZE.1) * 4 * 16);
    let files = DirectoryFiles::new(top.path().join("out"));
    for (i, photo) in result["photos"].as_array().unwrap().iter().enumerate() {
        let film = image::read(&files, &format!("0{i}.exr")).unwrap();
        assert_eq!((film.width, film.height), SIZE);
        let mean = film.pixels.iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / (3.0 * film.pixels.len() as f64);
        let told: f64 = photo["mean"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).sum::<f64>() / 3.0;
        assert!(mean > 0.05 && (mean - told).abs() < 1e-6, "{mean} {told}");
    }
    assert_eq!(result["photos"].as_array().unwrap().len(), 4);
}

#[test]
fn threads_change_no_bit_and_the_seed_does() {
    let top = scene(TRUTH);
    let render = |out: &str, more: [&str; 2]| {
        let common = ["render", "capture", "--photos", "01", "--samples", "8", "--out", out];
        succeeds(top.path(), &[&common[..], &more].concat());
        std::fs::read(top.path().join(out).join("01.exr")).unwrap()
    };
    let one = render("one", ["--threads", "1"]);
    assert!(one == render("two", ["--threads", "2"]));
    assert!(one != render("three", ["--seed", "1"]));
}

#[test]
fn buffers_hold_what_the_camera_sees_first() {
    let top = scene(TRUTH);
    let arguments = ["render", "capture", "--out", "out", "--samples", "2", "--buffers", "--photos", "00,03"];
    succeeds(top.path(), &arguments);
    let mut names: Vec<String> = std::fs::read_dir(top.path().join("out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["00.buffers.exr", "00.exr", "03.buffers.exr", "03.exr"]);
    // The header names the channels.
    let bytes = std::fs::read(top.path().join("out/00.buffers.exr")).unwrap();
    for channel in gonio_scene::film::FIRST_HIT_CHANNELS {
        assert!(bytes.windows(channel.len()).any(|window| window == channel.as_bytes()), "{channel}");
    }
}

#[test]
fn masks_are_white_where_objects_are_seen() {
    let top = scene(TRUTH);
    let shares = |out: &str, more: &[&str]| {
        let told = json(&succeeds(top.path(), &[&["mask", "capture", "--out", out, "--json"], more].concat()));
        let masks = told["masks"].as_array().unwrap().clone();
        assert_eq!(masks.len(), 4);
        masks.iter().map(|mask| mask["share"].as_f64().unwrap()).collect::<Vec<_>>()
    };
    let ball = shares("ball", &["--objects", "ball"]);
    let (larger, smaller) = (
        shares("larger", &["--objects", "ball", "--grow", "2"]),
        shares("smaller", &["--objects", "ball", "--grow", "-1"]),
    );
    for photo in 0..4 {
        assert!(0.0 < smaller[photo] && smaller[photo] < ball[photo] && ball[photo] < larger[photo]);
    }
    // Where the ball hides the board, the board is not white.
    let (board, both) = (shares("board", &["--objects", "board"]), shares("both", &["--objects", "ball,board"]));
    assert!((0..4).all(|photo| (ball[photo] + board[photo] - both[photo]).abs() < 1e-12));
    let mask = image::read(&DirectoryFiles::new(top.path().join("ball")), "00.png").unwrap();
    assert_eq!((mask.width, mask.height), SIZE);
    refused(top.path(), &["mask", "capture", "--out", "x"], &["--objects", "several objects", "ball, board"]);
    refused(top.path(), &["mask", "capture", "--out", "x", "--objects", "none"], &["--objects", "no object"]);
    refused(top.path(), &["mask", "capture", "--out", "x", "--grow", "999"], &["--grow"]);
}

#[test]
fn exposure_and_gain_scale_a_film() {
    let top = scene(TRUTH);
    let mean = |out: &str| {
        let arguments = ["render", "capture", "--out", out, "--samples", "4", "--photos", "00", "--json"];
        json(&succeeds(top.path(), &arguments))["photos"][0]["mean"][1].as_f64().unwrap()
    };
    let before = mean("before");
    edit(
        &top.path().join("capture/capture.toml"),
        "file = \"photos/00.exr\"",
        "file = \"photos/00.exr\"\nexposure = 2.0\ngain = 1.5",
    );
    assert!((mean("after") / before - 3.0).abs() < 1e-6);
}

#[test]
fn never_writes_over_the_capture() {
    let top = scene(TRUTH);
    let arguments = ["render", "capture", "--out", "capture/photos", "--samples", "2"];
    succeeds(top.path(), &arguments);
    let before = std::fs::read(top.path().join("capture/photos/00.exr")).unwrap();
    let again = gonio(top.path(), &[&arguments[..], &["--seed", "5"]].concat());
    assert_eq!(again.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&again.stderr).contains("--out"));
    assert_eq!(std::fs::read(top.path().join("capture/photos/00.exr")).unwrap(), before);
}

#[test]
fn samples_that_overflow_are_counted_and_told() {
    let top = blinded(scene(TRUTH));
    let arguments = ["render", "capture", "--out", "out", "--samples", "4"];
    let output = gonio(top.path(), &arguments);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("samples were NaN or infinite and count as black"), "{stderr}");
    let result = json(&succeeds(top.path(), &[&arguments[..], &["--json"]].concat()));
    let invalid = result["invalid_samples"].as_u64().unwrap();
    // At least those that see the sky itself, at most all, in the two photos that have one; the others are as they were.
    let samples = u64::from(SIZE.0 * SIZE.1) * 4;
    assert!(invalid > samples / 2 && invalid <= 2 * samples, "{invalid}");
    assert!(result["photos"][0]["mean"][0].as_f64().unwrap() > 0.05);
}
