//! `gonio calibrate` and `gonio new`: a camera from photos of a board, and a capture made with it.

use crate::exposures::{sky, stack};
use crate::fixture::{TRUTH, capture, gonio, gray_png, json, refused, scene, succeeds};
use gonio_scene::capture::{LightKind, Response};
use gonio_scene::image::write_png8;
use markers::MARKERS;
use std::path::Path;

#[path = "../../calibrate/tests/markers/mod.rs"]
mod markers;

const BOARD: &str = "charuco:5x7:0.04:0.02:6X6_250";
const SIZE: [u32; 2] = [640, 480];
const FOCAL: f64 = 600.0;

/// Brightness of the board at column `u` and row `v` in squares, from the upper left.
fn board(u: f64, v: f64) -> f64 {
    if !(0.0..5.0).contains(&u) || !(0.0..7.0).contains(&v) {
        return 0.85;
    }
    let (i, j) = (u.floor(), v.floor());
    if (i + j) % 2.0 == 0.0 {
        return 0.1;
    }
    let (x, y) = ((u - i - 0.25) * 16.0, (v - j - 0.25) * 16.0);
    if !(0.0..8.0).contains(&x) || !(0.0..8.0).contains(&y) {
        return 0.9;
    }
    let (column, row) = (x as u64, y as u64);
    if !(1..7).contains(&column) || !(1..7).contains(&row) {
        return 0.1;
    }
    let marker = MARKERS[(5 * j as usize + i as usize) / 2];
    if marker >> (35 - 6 * (row - 1) - (column - 1)) & 1 == 1 { 0.9 } else { 0.1 }
}

/// A photograph of the board by a pinhole camera, turned about two axes; 3 x 3 samples a pixel.
fn photograph(file: &Path, [about_x, about_y]: [f64; 2], distance: f64) {
    let ((sx, cx), (sy, cy)) = (about_x.sin_cos(), about_y.sin_cos());
    // Columns of the rotation Ry Rx: where the board's axes point.
    let (along_u, along_v) = ([cy, 0.0, -sy], [sy * sx, cx, cy * sx]);
    let middle = [0.1, 0.14];
    let origin: [f64; 3] =
        std::array::from_fn(|k| if k == 2 { distance } else { 0.0 } - middle[0] * along_u[k] - middle[1] * along_v[k]);
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let normal = cross(along_u, along_v);
    let sample = |x: f64, y: f64| {
        let ray = [(x - 320.0) / FOCAL, (y - 240.0) / FOCAL, 1.0];
        let depth = dot(origin, normal) / dot(ray, normal);
        let point = std::array::from_fn(|k| ray[k] * depth - origin[k]);
        board(dot(point, along_u) / 0.04, dot(point, along_v) / 0.04)
    };
    let pixel = |k: u32| {
        let (x, y) = (f64::from(k % SIZE[0]), f64::from(k / SIZE[0]));
        let sum: f64 =
            (0..9).map(|s| sample(x + (f64::from(s % 3) + 0.5) / 3.0, y + (f64::from(s / 3) + 0.5) / 3.0)).sum();
        [(255.0 * sum / 9.0).round() as u8; 3]
    };
    write_png8(file, SIZE[0], SIZE[1], &(0..SIZE[0] * SIZE[1]).map(pixel).collect::<Vec<_>>()).unwrap();
}

#[test]
fn a_board_gives_the_camera_and_a_capture_takes_its_poses() {
    let top = scene(TRUTH);
    let at = top.path();
    for (k, turn) in [[0.5, 0.1], [-0.45, 0.2], [0.1, -0.5], [0.2, 0.45]].into_iter().enumerate() {
        photograph(&at.join(format!("p{k}.png")), turn, 0.42);
    }
    gray_png(&at.join("empty.png"), SIZE[0], SIZE[1]);
    let photos = ["p0.png", "p1.png", "p2.png", "p3.png"];
    let command = |photos: &[&'static str], out: &'static str| {
        [&["calibrate"], photos, &["--board", BOARD, "--out", out, "--json"]].concat()
    };
    let output = gonio(at, &command(&[&photos[..], &["empty.png"]].concat(), "board/capture.toml"));
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("warning: empty.png: does not show the board"), "{stderr}");
    let told = json(&String::from_utf8(output.stdout).unwrap());
    let number = |key: &str| told["camera"][key].as_f64().unwrap();
    println!("{told}");
    assert!(told["error"].as_f64().unwrap() < 0.2 && (number("fx") / FOCAL - 1.0).abs() < 0.01, "{told}");
    assert!((number("cx") - 320.0).abs() < 4.0 && (number("cy") - 240.0).abs() < 4.0, "{told}");
    assert_eq!(capture(&at.join("board")).photos.len(), 4);

    // The same photos with a part, a map and the camera's response.
    let names = stack(at, &sky(32), &[1.0, 0.5, 0.25, 0.125, 0.0625, 0.03]);
    let stack: Vec<&str> = names.iter().map(String::as_str).collect();
    succeeds(at, &[&["hdr"], &stack[..], &["--times", "times.csv", "--out", "map.exr"]].concat());
    let poses = ["new", "--poses", "board", "--out", "part/capture.toml", "--meshes", "capture/ball.ply"];
    let more = ["--environment", "map.exr", "--response", "map.response.json", "--unit", "1"];
    succeeds(at, &[&poses[..], &more].concat());
    let part = capture(&at.join("part"));
    assert_eq!(part.photos[2].camera_to_world, capture(&at.join("board")).photos[2].camera_to_world);
    assert!(matches!(&part.lights[0].kind, LightKind::Map { map, .. } if map == "../map.exr"));
    assert!(matches!(part.sensor.response, Response::Curve(_)));
    let text = std::fs::read_to_string(at.join("part/capture.toml")).unwrap();
    assert!(text.contains("\nresponse = \"../map.response.json\"\n") && !text.contains("sRGB"), "{text}");
    // No pose is a guess, the scale of the map's light is.
    assert!(!text.contains("GUESS: on a circle") && text.contains("GUESS: the map's own brightness"), "{text}");
    succeeds(at, &["check", "part"]);

    let guessed = ["new", "--photos", "p0.png", "--meshes", "capture/ball.ply", "--out", "guess/capture.toml"];
    succeeds(at, &guessed);
    refused(at, &guessed, &["guess/capture.toml: exists already", "--out"]);
    let new = |out: &'static str, more: &[&'static str]| [&["new", "--out", out], more].concat();
    refused(at, &new("x/other.toml", &["--photos", "p0.png"]), &["x/other.toml: is no place for a capture"]);
    refused(
        at,
        &new("x/capture.toml", &["--photos", "empty.png", "--poses", "board"]),
        &["has no pose in board", "leave the photo out"],
    );
    refused(at, &new("x/capture.toml", &["--photos", "p0.png", "--poses", "nowhere"]), &["nowhere: does not exist"]);
    refused(
        at,
        &new("x/capture.toml", &["--photos", "p0.png", "--environment", "no.exr"]),
        &["no.exr: cannot be read", "correct the path"],
    );
    refused(at, &new("x/capture.toml", &["--photos", "p0.png", "--meshes", "p0.png"]), &["p0.png: "]);
    std::fs::write(at.join("flat.json"), serde_json::json!({ "log_exposure": vec![vec![1.0; 256]; 3] }).to_string())
        .unwrap();
    let curve = ["--photos", "p0.png", "--response", "flat.json"];
    refused(at, &new("x/capture.toml", &curve), &["flat.json: log_exposure: red does not rise", "gonio hdr"]);
    let curve = ["--photos", "p0.png", "--response", "map.exr"];
    refused(at, &new("x/capture.toml", &curve), &["map.exr: --response: ", ".json"]);

    let bad =
        |photos: &[&'static str]| [&["calibrate"], photos, &["--board", BOARD, "--out", "bad/capture.toml"]].concat();
    refused(at, &bad(&photos[..2]), &["--board: ", "at least 3"]);
    refused(at, &bad(&["empty.png", "empty.png", "empty.png"]), &["--board: "]);
    refused(at, &bad(&["p0.png", "p1.png", "none.png"]), &["none.png: ", "correct the path"]);
    gray_png(&at.join("small.png"), 320, 240);
    refused(
        at,
        &bad(&["p0.png", "small.png", "p1.png"]),
        &["small.png: is 320 x 240, the first photo 640 x 480", "one camera"],
    );
    for (board, says) in [
        ("charuco:5x7", "write charuco:"),
        ("charuco:5x7:0.02:0.04:6X6_250", "smaller than the square"),
        ("charuco:5x7:0.04:0.02:9X9_9", "no dictionary"),
    ] {
        refused(at, &["calibrate", "p0.png", "--board", board, "--out", "bad/capture.toml"], &["--board", says]);
    }
    assert!(!at.join("bad/capture.toml").exists());
}
