//! `gonio hdr`, and what a fit makes of its map and of its response.

use crate::exposures::{UNIT, photograph, sky, stack};
use crate::fixture::{TRUTH, capture_file, edit, gonio, json, refused, scene, succeeds};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::{Image, read, write_exr, write_png8};
use std::path::Path;
use tempfile::TempDir;

/// The lamp of the fixture's capture, and a sky in its place.
const LAMP: &str = "name = \"led\"\nkind = \"point\"\nframe = \"camera\"\nposition = [0.05, 0.0, 0.0]\n\
    intensity = [0.3, 0.3, 0.3]\n";

fn under(top: &TempDir, map: &str, scale: f64) {
    let sky = format!("name = \"sky\"\nkind = \"environment\"\nmap = \"{map}\"\nscale = {scale:?}\n");
    edit(&capture_file(top), LAMP, &sky);
    edit(&capture_file(top), "\"light.led.intensity\"]\ngray = [\"light.led.intensity\"]", "\"light.sky.scale\"]");
}

/// Photographs under the true sky, whose map `gonio hdr` measured from a stack of exposures; the capture starts elsewhere.
fn photographed() -> TempDir {
    let top = scene(TRUTH);
    let capture = top.path().join("capture");
    let truth = sky(384);
    write_exr(&capture.join("true.exr"), &truth).unwrap();
    under(&top, "true.exr", 1.0);
    succeeds(top.path(), &["render", "capture", "--out", "capture/photos", "--samples", "2048", "--seed", "7"]);

    let seconds: Vec<f64> = (0..12).map(|k| 8.0 / f64::from(1 << k)).collect();
    let names = stack(top.path(), &truth, &seconds);
    let photos: Vec<&str> = names.iter().map(String::as_str).collect();
    let arguments = ["--times", "times.csv", "--out", "capture/map.exr", "--json"];
    let told = json(&succeeds(top.path(), &[&["hdr"], &photos[..], &arguments].concat()));
    assert_eq!((&told["corrected_times"], &told["photos"]), (&0.into(), &12.into()), "{told}");
    for file in ["map.response.json", "map.response.svg", "map.preview.png", "map.marks.png"] {
        assert!(capture.join(file).is_file(), "{file}");
    }
    // The response is reusable: the same photos give the same map by it.
    let known = ["--times", "times.csv", "--response", "capture/map.response.json", "--out", "again.exr"];
    succeeds(top.path(), &[&["hdr"], &photos[..], &known].concat());
    assert_eq!(std::fs::read(top.path().join("again.exr")).unwrap(), std::fs::read(capture.join("map.exr")).unwrap());
    let toml = capture_file(&top);
    edit(&toml, "map = \"true.exr\"\nscale = 1.0", "map = \"map.exr\"\nscale = 0.7");
    edit(&toml, "base_color = [0.6, 0.35, 0.2]\nroughness = 0.35", "base_color = [0.5, 0.5, 0.5]\nroughness = 0.5");
    top
}

/// Fits and holds every parameter against the truth.
fn recovers(top: &TempDir, out: &str, scale: f64) {
    let result = json(&succeeds(top.path(), &["fit", "capture", "--out", out, "--json", "--samples", "1024"]));
    assert_eq!(result["converged"], true, "{result:#}");
    let truths = [
        ("light.sky.scale", scale, 0.005),
        ("material.shell.base_color.r", TRUTH.color[0], 0.01),
        ("material.shell.base_color.g", TRUTH.color[1], 0.01),
        ("material.shell.base_color.b", TRUTH.color[2], 0.015),
        ("material.shell.roughness", TRUTH.roughness, 0.025),
    ];
    let parameters = result["parameters"].as_array().unwrap();
    let found = truths.map(|(name, truth, _)| {
        let parameter = parameters.iter().find(|p| p["name"] == name).unwrap();
        let off = parameter["value"].as_f64().unwrap() / truth - 1.0;
        println!(
            "{out}: {name} {:+.2} % +- {:.2} %",
            100.0 * off,
            100.0 * parameter["standard_error"].as_f64().unwrap() / truth
        );
        off
    });
    for ((name, _, tolerance), off) in truths.iter().zip(found) {
        assert!(off.abs() < *tolerance, "{name}: {off}");
    }
}

/// The map is in units of the light that gives code 128, which linear photos know nothing of: there the scale is that light.
/// Photos of the same camera, read by the response that was learnt with the map, are in the map's own units.
#[test]
fn a_measured_map_lights_a_part_and_scale_and_materials_are_recovered() {
    let top = photographed();
    recovers(&top, "linear", UNIT);

    let photos = top.path().join("capture/photos");
    for k in 0..4 {
        let light = read(&DirectoryFiles::new(&photos), &format!("0{k}.exr")).unwrap();
        photograph(&photos.join(format!("0{k}.png")), &light, 0.4, 0.8, 100 + k);
        edit(
            &capture_file(&top),
            &format!("file = \"photos/0{k}.exr\""),
            &format!("file = \"photos/0{k}.png\"\nexposure = 0.4"),
        );
    }
    let sensor = "[sensor]\nread_noise = 0.0035\nsaturation = 0.98\nresponse = \"map.response.json\"\n";
    edit(&capture_file(&top), "[sensor]\nread_noise = 0.002\nshot_noise = 0.0002\n", sensor);
    recovers(&top, "encoded", 1.0);
    // The fitted capture holds the curve itself: it works wherever it is.
    let fitted = std::fs::read_to_string(top.path().join("encoded/capture.toml")).unwrap();
    assert!(fitted.contains("response = \"curve\"") && fitted.contains("[sensor.curve]"), "{fitted}");
    succeeds(top.path(), &["check", "encoded"]);
}

/// Two photos of a small ramp.
fn pair(seconds: [f64; 2]) -> TempDir {
    let top = tempfile::tempdir().unwrap();
    let pixels = (0..64 * 32).map(|k| [0.02 + (k % 64) as f32 / 40.0; 3]).collect();
    stack(top.path(), &Image { width: 64, height: 32, pixels }, &seconds);
    top
}

#[test]
fn a_measured_response_that_is_broken_is_refused_by_file_and_mend() {
    let top = scene(TRUTH);
    edit(&capture_file(&top), "[sensor]\n", "[sensor]\nresponse = \"map.response.json\"\n");
    refused(
        top.path(),
        &["check", "capture"],
        &["map.response.json: sensor.response: does not exist", "correct the path"],
    );
    let file = top.path().join("capture/map.response.json");
    let flat = serde_json::json!({ "log_exposure": vec![vec![0.0; 256]; 3] });
    std::fs::write(&file, flat.to_string()).unwrap();
    let says = ["map.response.json: log_exposure: red does not rise from code 0 to 1", "gonio hdr"];
    refused(top.path(), &["check", "capture"], &says);
    refused(top.path(), &["render", "capture", "--out", "r"], &says);
    edit(&capture_file(&top), "map.response.json", "map.response.txt");
    refused(top.path(), &["check", "capture"], &["capture.toml: sensor.response: is \"map.response.txt\"", ".json"]);
}

#[test]
fn bad_stacks_are_refused_by_file_key_and_mend() {
    let top = pair([1.0, 0.25]);
    let at = top.path();
    let hdr = |more: &[&'static str]| [&["hdr", "--out", "m.exr"], more].concat();
    let times = ["0.png", "1.png", "--times", "times.csv"];
    let timed = |more: &[&'static str]| hdr(&[&times[..], more].concat());
    refused(
        at,
        &hdr(&["0.png", "--times", "times.csv"]),
        &["0.png: PHOTOS: is a stack of fewer than two", "two or more"],
    );
    refused(at, &hdr(&["0.png", "1.png"]), &["0.png: ExposureTime: has no EXIF block", "--times"]);
    refused(at, &hdr(&["0.png", "9.png", "--times", "times.csv"]), &["9.png: ", "correct the path"]);
    refused(at, &hdr(&["0.png", "1.png", "--times", "t.csv"]), &["t.csv: cannot be read", "correct the path"]);
    write_png8(&at.join("small.png"), 32, 32, &[[9; 3]; 32 * 32]).unwrap();
    std::fs::write(at.join("more.csv"), "0.png,1\nsmall.png,0.5\n").unwrap();
    refused(at, &hdr(&["0.png", "small.png", "--times", "more.csv"]), &["small.png: is 32 x 32", "one size"]);
    std::fs::write(at.join("equal.csv"), "0.png,0.5\n1.png,0.5\n").unwrap();
    refused(
        at,
        &hdr(&["0.png", "1.png", "--times", "equal.csv"]),
        &["0.png: seconds: ", "all have an exposure of 0.5 s", "--times"],
    );
    for (list, line) in [("file,seconds\n0.png;1\n", 2), ("0.png,1\n1.png,fast\n", 2), ("0.png,1/\n", 1)] {
        std::fs::write(at.join("broken.csv"), list).unwrap();
        let line = format!("broken.csv: line {line}: holds ");
        refused(at, &hdr(&["0.png", "1.png", "--times", "broken.csv"]), &[&line, "write lines `file,seconds`"]);
    }
    for time in ["0", "-1", "nan", "inf", "1/0"] {
        std::fs::write(at.join("odd.csv"), format!("0.png,1\n1.png,{time}\n")).unwrap();
        refused(at, &hdr(&["0.png", "1.png", "--times", "odd.csv"]), &["1.png: seconds: "]);
    }
    refused(at, &timed(&["--level", "3"]), &["--level: write two numbers"]);
    refused(at, &timed(&["--fill-below", "95"]), &["fill-below", "-80 to 89"]);
    refused(at, &timed(&["--region", "central:2"]), &["--region", "central:PART"]);
    refused(at, &timed(&["--exclude", "blue"]), &["--exclude", "#RRGGBB"]);
    std::fs::write(at.join("r.json"), "{\"log_exposure\": []}").unwrap();
    refused(at, &timed(&["--response", "r.json"]), &["r.json: is no response curve", "gonio hdr"]);
    assert!(!at.join("m.exr").exists());
    // A square is no panorama.
    let square = pair_of(at, 32);
    refused(
        at,
        &[&hdr(&["--turn", "10"])[..], &square.iter().map(String::as_str).collect::<Vec<_>>()].concat(),
        &["m.exr: turn: is 32 x 32", "--turn"],
    );
}

/// A square stack and its list, as arguments.
fn pair_of(at: &Path, side: u32) -> Vec<String> {
    let folder = at.join("square");
    std::fs::create_dir(&folder).unwrap();
    let pixels = (0..side * side).map(|k| [0.02 + (k % side) as f32 / 20.0; 3]).collect();
    let names = stack(&folder, &Image { width: side, height: side, pixels }, &[1.0, 0.25]);
    let mut arguments: Vec<String> = names.iter().map(|name| format!("square/{name}")).collect();
    arguments.extend(["--times".to_owned(), "square/times.csv".to_owned()]);
    arguments
}

#[test]
fn a_wrong_time_is_named_and_a_panorama_is_turned_and_filled() {
    let top = tempfile::tempdir().unwrap();
    let seconds: Vec<f64> = (0..8).map(|k| 4.0 / f64::from(1 << k)).collect();
    let names = stack(top.path(), &sky(96), &seconds);
    let list = top.path().join("times.csv");
    edit(&list, "3.png,0.5\n", "3.png,0.9\n");
    let photos: Vec<&str> = names.iter().map(String::as_str).collect();
    let arguments = ["--times", "times.csv", "--out", "m.exr", "--turn", "90", "--level", "1,-2", "--fill-below", "20"];
    let output = gonio(top.path(), &[&["hdr"], &photos[..], &arguments].concat());
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("warning: 3.png: an exposure of 0.9000 s contradicts the other photos"), "{stderr}");
    // The sun was 2.2 rad from the left edge; it is a quarter turn further left now.
    let map = read(&DirectoryFiles::new(top.path()), "m.exr").unwrap();
    let brightest = (0..96 * 48).max_by(|&a, &b| map.pixels[a][0].total_cmp(&map.pixels[b][0])).unwrap();
    let column = 2.2 / std::f64::consts::TAU * 96.0 - 24.0;
    assert!(((brightest % 96) as f64 - column).abs() < 2.5, "{brightest} {column}");
}

#[test]
fn times_in_reverse_order_are_refused() {
    let top = tempfile::tempdir().unwrap();
    let names = stack(top.path(), &sky(32), &[1.0, 0.25, 0.0625, 0.015625]);
    let photos: Vec<&str> = names.iter().map(String::as_str).collect();
    let list = "file,seconds\n0.png,0.015625\n1.png,0.0625\n2.png,0.25\n3.png,1.0\n";
    std::fs::write(top.path().join("reversed.csv"), list).unwrap();
    let run = |times: &'static str| [&["hdr"], &photos[..], &["--times", times, "--out", "map.exr"]].concat();
    refused(
        top.path(),
        &run("reversed.csv"),
        &["3.png: seconds: has an exposure of 1 s and is darker than 0.png", "reverse"],
    );
    assert!(!top.path().join("map.exr").exists());
    succeeds(top.path(), &run("times.csv"));
}
