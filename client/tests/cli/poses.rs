//! `gonio calibrate`, `gonio import` and `gonio new`: cameras from a board, from others, and the captures made of them.

use crate::exposures::{sky, stack};
use crate::fixture::{TRUTH, gonio, json, refused, scene, succeeds};
use gonio_scene::Capture;
use gonio_scene::capture::{LightKind, Response};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::write_png8;
use std::path::Path;
use tempfile::TempDir;

const BOARD: &str = "charuco:5x7:0.04:0.02:6X6_250";
/// The first 17 markers of OpenCV's DICT_6X6_250, row by row from the highest bit, white is 1.
const MARKERS: [u64; 17] = [
    0x1_e3dd_82a6,
    0x0_efba_3891,
    0x1_5907_eacd,
    0xc_91b3_069e,
    0xd_607d_6e15,
    0xd_8e8e_0e68,
    0x4_268b_41f5,
    0x8_8a50_f29a,
    0x3_07d5_24fd,
    0x3_c2f3_4b3c,
    0x4_5dfc_74e3,
    0x4_8d85_b257,
    0x7_1055_8fc6,
    0x8_6dcf_ad07,
    0x8_d72a_93f6,
    0xa_2b89_dcde,
    0x0_9fd1_e9c4,
];
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

fn gray(file: &Path, width: u32, height: u32) {
    write_png8(file, width, height, &vec![[90; 3]; (width * height) as usize]).unwrap();
}

fn capture(at: &Path) -> Capture {
    Capture::read(&DirectoryFiles::new(at)).unwrap()
}

#[test]
fn a_board_gives_the_camera_and_a_capture_takes_its_poses() {
    let top = scene(TRUTH);
    let at = top.path();
    for (k, turn) in [[0.5, 0.1], [-0.45, 0.2], [0.1, -0.5], [0.2, 0.45]].into_iter().enumerate() {
        photograph(&at.join(format!("p{k}.png")), turn, 0.42);
    }
    gray(&at.join("empty.png"), SIZE[0], SIZE[1]);
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
    gray(&at.join("small.png"), 320, 240);
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

/// COLMAP's model of one camera and two images, as text and in its binary form.
fn models(at: &Path) {
    std::fs::create_dir_all(at.join("images")).unwrap();
    for name in ["a b.png", "c.png"] {
        gray(&at.join("images").join(name), 32, 24);
    }
    let (text, binary) = (at.join("sparse/text"), at.join("sparse/0"));
    std::fs::create_dir_all(&text).unwrap();
    std::fs::create_dir_all(&binary).unwrap();
    std::fs::write(text.join("cameras.txt"), "# cameras\n3 OPENCV 32 24 50 51 16 12 0.1 0 0 0\n").unwrap();
    std::fs::write(text.join("images.txt"), "7 0.6 0 0 0.8 0.1 0.2 2 3 a b.png\n\n8 1 0 0 0 0 0 1 3 c.png\n1 2 -1\n")
        .unwrap();
    let mut cameras =
        [1_u64.to_le_bytes().to_vec(), 3_u32.to_le_bytes().to_vec(), 4_u32.to_le_bytes().to_vec()].concat();
    cameras.extend([32_u64, 24].iter().flat_map(|side| side.to_le_bytes()));
    cameras.extend([50.0_f64, 51.0, 16.0, 12.0, 0.1, 0.0, 0.0, 0.0].iter().flat_map(|number| number.to_le_bytes()));
    std::fs::write(binary.join("cameras.bin"), cameras).unwrap();
    let mut images = 2_u64.to_le_bytes().to_vec();
    for (number, pose, name, points) in [
        (7_u32, [0.6_f64, 0.0, 0.0, 0.8, 0.1, 0.2, 2.0], "a b.png", 0_u64),
        (8, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], "c.png", 1),
    ] {
        images.extend(number.to_le_bytes());
        images.extend(pose.iter().flat_map(|number| number.to_le_bytes()));
        images.extend(3_u32.to_le_bytes());
        images.extend(name.bytes().chain([0]));
        images.extend(points.to_le_bytes());
        images.extend(vec![0; 24 * points as usize]);
    }
    std::fs::write(binary.join("images.bin"), images).unwrap();
}

#[test]
fn a_model_of_colmap_is_imported_from_text_and_from_its_binary_form_alike() {
    let top = tempfile::tempdir().unwrap();
    let at = top.path();
    models(at);
    let told = json(&succeeds(at, &["import", "colmap", "sparse/text", "--out", "t/capture.toml", "--json"]));
    assert_eq!(told["photos"], 2);
    succeeds(at, &["import", "colmap", "sparse/0", "--out", "b/capture.toml"]);
    let (text, binary) = (capture(&at.join("t")), capture(&at.join("b")));
    assert_eq!((&text.camera, &text.photos), (&binary.camera, &binary.photos));
    assert_eq!((text.photos[0].file.as_str(), text.camera.distortion[0]), ("../images/a b.png", 0.1));
    assert!((text.photos[1].camera_to_world[2][3] + 1.0).abs() < 1e-12);

    let import = |model: &'static str| ["import", "colmap", model, "--out", "x/capture.toml"];
    refused(at, &import("sparse"), &["cameras.txt: ", "cameras.bin and images.bin"]);
    std::fs::write(at.join("sparse/text/cameras.txt"), "3 OPENCV_FISHEYE 32 24 1 1 1 1 0 0 0 0\n").unwrap();
    refused(at, &import("sparse/text"), &["cameras.txt: line 1: is the model OPENCV_FISHEYE", "image_undistorter"]);
    let images = at.join("sparse/0/images.bin");
    let whole = std::fs::read(&images).unwrap();
    std::fs::write(&images, &whole[..whole.len() - 1]).unwrap();
    refused(at, &import("sparse/0"), &["images.bin: image 1: ends before its points do", "copy the file anew"]);
    std::fs::write(&images, [&u64::MAX.to_le_bytes(), &whole[8..]].concat()).unwrap();
    refused(at, &import("sparse/0"), &["images.bin: image 2: ends before its number"]);
    std::fs::remove_file(&images).unwrap();
    refused(at, &import("sparse/0"), &["images.bin: does not exist"]);
    std::fs::write(&images, &whole).unwrap();
    gray(&at.join("images/c.png"), 16, 12);
    refused(at, &import("sparse/0"), &["images/c.png: is 16 x 12, its camera in COLMAP's model 32 x 24", "--images"]);
    std::fs::remove_file(at.join("images/c.png")).unwrap();
    refused(at, &import("sparse/0"), &["c.png: is not in", "--images"]);
}

fn import_top() -> TempDir {
    let top = tempfile::tempdir().unwrap();
    gray(&top.path().join("r_0.png"), 40, 20);
    top
}

#[test]
fn transforms_and_scenes_of_bop_are_imported() {
    let top = import_top();
    let at = top.path();
    let identity = "[[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]";
    let good =
        format!(r#"{{"camera_angle_x": 0.9, "frames": [{{"file_path": "./r_0", "transform_matrix": {identity}}}]}}"#);
    std::fs::write(at.join("transforms.json"), &good).unwrap();
    succeeds(at, &["import", "transforms", "transforms.json", "--out", "t/capture.toml"]);
    let imported = capture(&at.join("t"));
    assert_eq!((imported.photos[0].file.as_str(), imported.camera.width), ("../r_0.png", 40));
    let import = ["import", "transforms", "transforms.json", "--out", "x/capture.toml"];
    for (text, says) in [
        ("{", "transforms.json: is no JSON"),
        ("{}", "transforms.json: frames: is missing"),
        (&good.replace("0.9", "\"wide\""), "transforms.json: "),
        (&good.replace("./r_0", "./r_9"), "r_9: frames[0].file_path: is not in"),
        (&good.replace(identity, "[[1,0,0,0]]"), "transforms.json: frames[0].transform_matrix: "),
    ] {
        std::fs::write(at.join("transforms.json"), text).unwrap();
        refused(at, &import, &[says]);
    }
    refused(
        at,
        &["import", "transforms", "none.json", "--out", "x/capture.toml"],
        &["none.json: does not exist", "transforms.json"],
    );

    let scene = at.join("test/000002");
    std::fs::create_dir_all(scene.join("rgb")).unwrap();
    gray(&scene.join("rgb/000003.png"), 40, 20);
    std::fs::create_dir(at.join("models")).unwrap();
    std::fs::write(at.join("models/obj_000005.ply"), "ply\n").unwrap();
    let camera = r#"{"3": {"cam_K": [50,0,20,0,50,10,0,0,1]}}"#;
    let truth = r#"{"3": [{"cam_R_m2c": [0,-1,0,1,0,0,0,0,1], "cam_t_m2c": [100,0,1000], "obj_id": 5}]}"#;
    std::fs::write(scene.join("scene_camera.json"), camera).unwrap();
    std::fs::write(scene.join("scene_gt.json"), truth).unwrap();
    let import =
        |out: &'static str, more: &[&'static str]| [&["import", "bop", "test/000002", "--out", out], more].concat();
    let told = json(&succeeds(at, &import("b/capture.toml", &["--json", "--models", "models"])));
    assert_eq!((&told["photos"], &told["objects"]), (&1.into(), &1.into()));
    assert_eq!(capture(&at.join("b")).objects[0].mesh, "../models/obj_000005.ply");
    refused(at, &import("x/capture.toml", &["--models", "rgb"]), &["obj_000005.ply: is not in rgb", "--models"]);
    std::fs::write(scene.join("scene_camera.json"), "{\"3\": {}}").unwrap();
    refused(at, &import("x/capture.toml", &[]), &["scene_camera.json: 3.cam_K: is missing"]);
    std::fs::write(scene.join("scene_camera.json"), camera.replace("\"3\"", "\"4\"")).unwrap();
    refused(at, &import("x/capture.toml", &[]), &["scene_gt.json: 4: is missing"]);
    refused(
        at,
        &["import", "bop", "nowhere", "--out", "x/capture.toml"],
        &["scene_camera.json: does not exist", "000002"],
    );
    refused(
        at,
        &["import", "colmap", "test", "--models", "models", "--out", "x/capture.toml"],
        &["--models: is for bop alone"],
    );
}
