//! Bad input: exit code 2, one line that names file and key, no panic.

use crate::fixture::{SIZE, capture_file, edit, gonio, gray};
use gonio_scene::image::{Image, encode_exr_channels, write_exr, write_png8};
use std::path::Path;

/// Breaks the capture in the folder.
type Break = fn(&Path);

fn replace(root: &Path, from: &str, to: &str) {
    edit(&root.join("capture.toml"), from, to);
}

fn photo(root: &Path, size: (u32, u32), value: f32) {
    let (width, height) = size;
    let pixels = vec![value; (width * height) as usize];
    let channels = ["R", "G", "B"].map(|name| (name, pixels.clone()));
    let bytes = encode_exr_channels("x", width, height, &channels).unwrap();
    std::fs::write(root.join("photos/03.exr"), bytes).unwrap();
}

fn mask(root: &Path, size: (u32, u32), value: u8) {
    let pixels = vec![[value; 3]; (size.0 * size.1) as usize];
    write_png8(&root.join("photos/mask.png"), size.0, size.1, &pixels).unwrap();
    replace(root, "file = \"photos/03.exr\"", "file = \"photos/03.exr\"\nmask = \"photos/mask.png\"");
}

/// What is broken, how, and what the error must name.
const CASES: &[(&str, Break, &[&str])] = &[
    ("no TOML", |r| std::fs::write(r.join("capture.toml"), "format = ").unwrap(), &["capture.toml", "TOML"]),
    ("no capture.toml", |r| std::fs::remove_file(r.join("capture.toml")).unwrap(), &["capture.toml", "does not exist"]),
    ("another format", |r| replace(r, "format = 1", "format = 2"), &["capture.toml", "format"]),
    ("unknown key", |r| replace(r, "roughness = 0.5", "roughnes = 0.5"), &["material.shell.roughnes", "roughness"]),
    ("unknown section", |r| replace(r, "[sensor]", "[sensors]"), &["capture.toml", "sensors"]),
    ("wrong type", |r| replace(r, "ior = 1.5", "ior = \"glass\""), &["material.shell.ior", "number"]),
    ("out of range", |r| replace(r, "roughness = 0.5", "roughness = 1.7"), &["material.shell.roughness", "1.7"]),
    ("not a number", |r| replace(r, "ior = 1.5", "ior = nan"), &["material.shell.ior", "NaN"]),
    ("missing key", |r| replace(r, "fx = 48.0\n", ""), &["camera.fx", "missing"]),
    ("unknown model", |r| replace(r, "\"lambert\"", "\"velvet\""), &["material.paint.model", "velvet"]),
    (
        "unknown material",
        |r| replace(r, "material = \"paint\"", "material = \"gold\""),
        &["object.board.material", "gold"],
    ),
    (
        "unknown light",
        |r| replace(r, "role = \"fit\"", "role = \"fit\"\nlights = [\"sun\"]"),
        &["photo.00.lights", "sun"],
    ),
    (
        "unknown free name",
        |r| replace(r, "\"material.shell.roughness\"", "\"material.shell.gloss\""),
        &["material.shell.gloss"],
    ),
    (
        "no rotation",
        |r| replace(r, "camera_to_world = [[-0.29", "camera_to_world = [[-0.99"),
        &["photos/00.exr.camera_to_world", "rotation"],
    ),
    ("missing mesh", |r| std::fs::remove_file(r.join("ball.ply")).unwrap(), &["ball.ply", "does not exist"]),
    ("truncated mesh", |r| truncate(r, "ball.ply", 900), &["ball.ply"]),
    ("missing photo", |r| std::fs::remove_file(r.join("photos/03.exr")).unwrap(), &["photos/03.exr", "does not exist"]),
    ("truncated photo", |r| truncate(r, "photos/03.exr", 400), &["photos/03.exr"]),
    ("wrong photo size", |r| photo(r, (24, 32), 0.5), &["photo.03", "24x32", "32x24"]),
    ("NaN in a photo", |r| photo(r, SIZE, f32::NAN), &["photos/03.exr", "not a number"]),
    ("a folder as a photo", |r| replace(r, "photos/03.exr", "photos"), &["photos"]),
    ("wrong mask size", |r| mask(r, (8, 8), 255), &["photo.03", "mask", "8x8"]),
    ("mask of zeros and ones", |r| mask(r, SIZE, 1), &["photos/mask.png", "255"]),
    ("empty mask", |r| mask(r, SIZE, 0), &["photos/03.exr", "empty mask"]),
    (
        "missing mask",
        |r| replace(r, "file = \"photos/03.exr\"", "file = \"photos/03.exr\"\nmask = \"m.png\""),
        &["m.png"],
    ),
    (
        "clipped photo",
        |r| replace(r, "read_noise = 0.002", "read_noise = 0.002\nsaturation = 0.2"),
        &["photos/00.exr", "clipped"],
    ),
];

fn truncate(root: &Path, file: &str, length: usize) {
    let bytes = std::fs::read(root.join(file)).unwrap();
    assert!(bytes.len() > length, "{file} has {} bytes", bytes.len());
    std::fs::write(root.join(file), &bytes[..length]).unwrap();
}

/// That `arguments` fail with exit code 2 and an error that names all of `parts`.
fn refused(at: &Path, case: &str, arguments: &[&str], parts: &[&str]) {
    let output = gonio(at, arguments);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{case}: {stderr}");
    assert!(!stderr.contains("panicked") && !stderr.contains("backtrace"), "{case}: {stderr}");
    let named = |line: &str| line.starts_with("error: ") && parts.iter().all(|part| line.contains(part));
    assert!(stderr.lines().any(named), "{case}: {parts:?} not in one line of {stderr}");
}

#[test]
fn a_broken_capture_is_refused_by_check_and_by_fit() {
    for (case, damage, parts) in CASES {
        let top = gray();
        damage(&top.path().join("capture"));
        refused(top.path(), case, &["check", "capture"], parts);
        refused(top.path(), case, &["fit", "capture", "--out", "out"], parts);
    }
}

#[test]
fn rendering_needs_the_scene_but_no_photographs() {
    let top = gray();
    let root = top.path().join("capture");
    std::fs::remove_dir_all(root.join("photos")).unwrap();
    std::fs::remove_file(root.join("board.ply")).unwrap();
    refused(top.path(), "missing mesh", &["render", "capture", "--out", "out"], &["board.ply", "does not exist"]);
}

#[test]
fn wrong_usage_is_refused() {
    let top = gray();
    let at = top.path();
    let fit = |more: &[&'static str]| [&["fit", "capture", "--out", "out"], more].concat();
    let render = |more: &[&'static str]| [&["render", "capture", "--out", "out"], more].concat();
    refused(at, "no capture", &["check", "nowhere"], &["nowhere", "does not exist"]);
    refused(at, "another file", &["check", "capture/ball.ply"], &["ball.ply", "capture.toml"]);
    refused(at, "odd samples", &render(&["--samples", "3"]), &["--samples", "even"]);
    refused(at, "unknown photo", &render(&["--photos", "77"]), &["--photos", "77"]);
    refused(at, "unknown solver", &fit(&["--solver", "adam"]), &["--solver", "gauss-newton"]);
    refused(at, "start without value", &fit(&["--start", "material.shell.ior"]), &["--start"]);
    refused(at, "start of what is not free", &fit(&["--start", "material.shell.ior=1.4"]), &["material.shell.ior"]);
    refused(at, "start out of range", &fit(&["--start", "material.shell.roughness=4"]), &["material.shell.roughness"]);
    refused(at, "free unknown", &fit(&["--free", "material.shell.gloss"]), &["material.shell.gloss"]);
    refused(at, "no iterations", &fit(&["--max-iterations", "0"]), &["--max-iterations"]);
    refused(at, "no address", &fit(&["--farm", "not a url"]), &["--farm"]);
    refused(at, "resume from nothing", &fit(&["--resume"]), &["checkpoint.json"]);
    refused(at, "unwritable folder", &["fit", "capture", "--out", "capture/ball.ply/x"], &["ball.ply", "--out"]);
    refused(at, "over the capture", &["fit", "capture", "--out", "capture"], &["capture.toml", "--out"]);
    edit(&capture_file(&top), "role = \"fit\"", "role = \"held-out\"");
    refused(at, "nothing to fit to", &fit(&[]), &["photo", "held-out"]);
}

#[test]
fn a_farm_that_does_not_answer_is_no_fault_of_the_input() {
    let top = gray();
    // Port 9 (discard) is closed wherever tests run.
    let output = gonio(top.path(), &["render", "capture", "--out", "out", "--farm", "http://127.0.0.1:9", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let stderr = String::from_utf8(output.stderr).unwrap();
    let error: serde_json::Value = serde_json::from_str(stderr.lines().last().unwrap()).unwrap();
    assert_eq!((&error["event"], &error["exit_code"]), (&"error".into(), &1.into()));
}

#[test]
fn a_photo_of_another_kind_of_file_is_named() {
    let top = gray();
    let image = Image { width: 2, height: 2, pixels: vec![[0.5; 3]; 4] };
    write_exr(&top.path().join("capture/photos/x.exr"), &image).unwrap();
    std::fs::rename(top.path().join("capture/photos/x.exr"), top.path().join("capture/photos/x.png")).unwrap();
    edit(&capture_file(&top), "photos/03.exr", "photos/x.png");
    refused(top.path(), "EXR as PNG", &["check", "capture"], &["photos/x.png", "OpenExr"]);
}
