//! `gonio calibrate` and `gonio new`: a camera from photos of a board, and a capture made with it.

use crate::exposures::{sky, stack};
use crate::fixture::{TRUTH, capture, gonio, gray_png, json, refused, scene, succeeds};
use drawn::{FOCAL, SIZE, charuco, photograph};
use gonio_scene::Capture;
use gonio_scene::capture::{LightKind, Response, Role};
use gonio_scene::image::write_png8;
use std::path::Path;

#[path = "../../calibrate/tests/drawn/mod.rs"]
mod drawn;
#[path = "../../calibrate/tests/markers/mod.rs"]
mod markers;

const BOARD: &str = "charuco:5x7:0.04:0.02:6X6_250";

/// A photograph of the board, turned about two axes.
fn shot(file: &Path, turn: [f64; 2]) {
    let gray = photograph(&charuco, [0.1, 0.14], turn, 0.42);
    write_png8(file, SIZE[0], SIZE[1], &gray.into_iter().map(|value| [value; 3]).collect::<Vec<_>>()).unwrap();
}

/// What `--intrinsics` and `--fix` hold is not looked for.
fn poses_of_a_known_camera(at: &Path, told: &serde_json::Value) {
    let command = |photos: &[&'static str], out: &'static str, more: &[&'static str]| {
        [&["calibrate", "--board", BOARD, "--out", out], more, photos].concat()
    };
    let photos = ["p0.png", "p1.png", "p2.png", "p3.png"];
    let plain = json(&succeeds(at, &command(&photos, "plain/capture.toml", &["--json", "--fix", "distortion"])));
    for key in ["k1", "k2", "p1", "p2", "k3"] {
        assert_eq!(plain["camera"][key].as_f64(), Some(0.0), "{plain}");
    }
    std::fs::write(at.join("camera.json"), told.to_string()).unwrap();
    let whole = capture(&at.join("board"));
    for (out, file) in [("known/capture.toml", "board"), ("known2/capture.toml", "camera.json")] {
        let one = json(&succeeds(at, &command(&["p1.png"], out, &["--json", "--intrinsics", file])));
        assert_eq!(one["camera"], told["camera"]);
        let known = capture(at.join(out).parent().unwrap());
        let (own, all) = (known.photos[0].camera_to_world, whole.photos[1].camera_to_world);
        assert!((0..3).all(|k| (own[k][3] - all[k][3]).abs() < 1e-3), "{own:?} {all:?}");
    }
    let refuse =
        |more: &[&'static str], says: &[&str]| refused(at, &command(&["p1.png"], "bad/capture.toml", more), says);
    refuse(&["--intrinsics", "nowhere.json"], &["--intrinsics nowhere.json", "cannot be read"]);
    std::fs::write(at.join("none.json"), "{}").unwrap();
    refuse(&["--intrinsics", "none.json"], &["camera.width", "gonio calibrate --json"]);
    let mut small = told.clone();
    small["camera"]["width"] = 320.into();
    std::fs::write(at.join("small.json"), small.to_string()).unwrap();
    refuse(&["--intrinsics", "small.json"], &["--intrinsics small.json", "320 x 480", "640 x 480"]);
    let nothing = command(&["empty.png"], "bad/capture.toml", &["--intrinsics", "board"]);
    refused(at, &nothing, &["--board: no photo shows"]);
}

/// What fits at once: the part's place, masks, the board, a lamp and the room, what is free and who judges. One photo without
/// a pose does not end it.
fn whole_capture(at: &Path) {
    std::fs::create_dir(at.join("masks")).unwrap();
    for name in ["p0", "p1.mask"] {
        let white = vec![[255; 3]; (SIZE[0] * SIZE[1]) as usize];
        write_png8(&at.join(format!("masks/{name}.png")), SIZE[0], SIZE[1], &white).unwrap();
    }
    let photos = ["--photos", "p0.png", "p1.png", "empty.png", "p2.png", "p3.png", "--poses", "board"];
    let more = ["--meshes", "capture/ball.ply", "--unit", "0.001", "--at", "0.1,-0.14,0.02,90", "--masks", "masks"];
    let light = ["--board", BOARD, "--lamp", "0.5,-0.2,0.7,0.03", "--room", "--out", "whole/capture.toml"];
    let output = gonio(at, &[&["new"], &photos[..], &more, &light].concat());
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("empty.png: has no pose and is left out"), "{stderr}");
    assert!(stderr.contains("no mask for p2, p3"), "{stderr}");
    let whole = capture(&at.join("whole"));
    let place = whole.objects[0].object_to_world;
    assert!((place[1][0] - 0.001).abs() < 1e-12 && place[0][0].abs() < 1e-12 && place[1][3] == -0.14, "{place:?}");
    assert_eq!(whole.photos[1].mask.as_deref(), Some("../masks/p1.mask.png"));
    let judges = |capture: &Capture| capture.photos.iter().filter(|photo| photo.role == Role::HeldOut).count();
    assert_eq!(judges(&whole), 0, "four photos are too few to keep one back");
    succeeds(
        at,
        &["new", "--photos", "p0.png", "p1.png", "p2.png", "p3.png", "empty.png", "--out", "five/capture.toml"],
    );
    assert_eq!(judges(&capture(&at.join("five"))), 1);
    let objects: Vec<&str> = whole.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(objects, ["ball", "board-white", "board-black"]);
    assert!(matches!(whole.lights[0].kind, LightKind::Sphere { radius: 0.03, .. }));
    let free = ["material.surface.base_color", "material.surface.roughness", "light.lamp.intensity"];
    assert_eq!(whole.fit.parameters, [&free[..], &["light.lamp.position", "light.room.radiance"]].concat());
    assert!(whole.sensor.read_noise > 0.0);
    succeeds(at, &["check", "whole"]);
    let bad = |option: &'static str, value: &'static str, says: &[&str]| {
        refused(at, &["new", "--photos", "p0.png", "--out", "x/capture.toml", option, value], says);
    };
    bad("--at", "0.1,0.2", &["--at", "write X,Y,Z"]);
    bad("--lamp", "0.1,0.2,0.3,-1", &["--lamp", "RADIUS"]);
    bad("--board", "charuco:5x7", &["--board", "write charuco:"]);
    bad("--masks", "nowhere", &["--masks", "cannot be read"]);
    bad("--masks", "capture", &["--masks", "for none of the photos", "name masks as their photos"]);
}

#[test]
fn a_board_gives_the_camera_and_a_capture_takes_its_poses() {
    let top = scene(TRUTH);
    let at = top.path();
    for (k, turn) in [[0.5, 0.1], [-0.45, 0.2], [0.1, -0.5], [0.2, 0.45]].into_iter().enumerate() {
        shot(&at.join(format!("p{k}.png")), turn);
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

    poses_of_a_known_camera(at, &told);

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

    whole_capture(at);

    let guessed = ["new", "--photos", "p0.png", "--meshes", "capture/ball.ply", "--out", "guess/capture.toml"];
    succeeds(at, &guessed);
    refused(at, &guessed, &["guess/capture.toml: exists already", "--out"]);
    let new = |out: &'static str, more: &[&'static str]| [&["new", "--out", out], more].concat();
    refused(at, &new("x/other.toml", &["--photos", "p0.png"]), &["x/other.toml: is no place for a capture"]);
    refused(
        at,
        &new("x/capture.toml", &["--photos", "empty.png", "--poses", "board"]),
        &["empty.png: has no pose in board, nor has any other photo", "--poses"],
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
        ("charuco:7x5:0.04:0.02:6X6_250", "write charuco:5x7:0.04:0.02:6X6_250"),
        ("charuco:5x7:40:20:6X6_250", "if these are millimetres"),
        ("charuco:5x7:0.04:0.02:9X9_9", "no dictionary"),
    ] {
        refused(at, &["calibrate", "p0.png", "--board", board, "--out", "bad/capture.toml"], &["--board", says]);
    }
    assert!(!at.join("bad/capture.toml").exists());
}
