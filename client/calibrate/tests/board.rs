//! Calibration: on generated corners, and on OpenCV's photographs in the folder that `GONIO_REAL` names or in
//! `../shared/real` beside the checkout (skipped where there is none).

#![allow(clippy::unwrap_used)] // a test fails by panicking

mod markers;

use gonio_calibrate::{Board, Corner, Pose, calibrate, project};
use gonio_scene::capture::Camera;
use markers::MARKERS;
use nalgebra::{Rotation3, Vector3};
use std::path::PathBuf;

const BOARD: &str = "charuco:5x7:0.04:0.02:6X6_250";

/// What OpenCV 5.0.0's CharucoDetector finds in choriginal.jpg, by number; its pixel centres are whole numbers.
const GOLDEN: [(u32, [f64; 2]); 24] = [
    (0, [248.538, 101.593]),
    (1, [295.659, 108.606]),
    (2, [342.683, 116.105]),
    (3, [390.354, 123.485]),
    (4, [237.760, 139.366]),
    (5, [286.891, 146.503]),
    (6, [335.992, 154.441]),
    (7, [385.652, 162.214]),
    (8, [225.998, 180.108]),
    (9, [277.511, 187.841]),
    (10, [328.593, 196.240]),
    (11, [380.565, 204.465]),
    (12, [213.004, 224.518]),
    (13, [266.871, 233.715]),
    (14, [320.782, 242.488]),
    (15, [375.122, 250.955]),
    (16, [198.734, 273.943]),
    (17, [255.479, 283.533]),
    (18, [311.681, 292.889]),
    (19, [368.916, 302.465]),
    (20, [182.809, 328.863]),
    (21, [242.476, 339.109]),
    (22, [301.930, 348.766]),
    (23, [362.374, 359.003]),
];

fn real() -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    let folder = std::env::var_os("GONIO_REAL").map_or_else(beside, PathBuf::from).join("charuco");
    if !folder.is_dir() {
        println!("skipped: no charuco in GONIO_REAL or ../shared/real");
        return None;
    }
    Some(folder)
}

fn corners(folder: &std::path::Path, name: &str) -> (u32, u32, Vec<Corner>) {
    let gray = image::open(folder.join(name)).unwrap().to_luma8();
    let (width, height) = gray.dimensions();
    (width, height, Board::parse(BOARD).unwrap().find(width, height, &gray))
}

#[test]
fn corners_lie_within_a_pixel_of_opencvs() {
    let Some(folder) = real() else { return };
    let (_, _, found) = corners(&folder, "choriginal.jpg");
    let mut worst: f64 = 0.0;
    let mut mean = [0.0; 2];
    for (id, [x, y]) in GOLDEN {
        let corner = found.iter().find(|corner| corner.id == id).unwrap_or_else(|| panic!("no corner {id}"));
        let (dx, dy) = (corner.pixel[0] - 0.5 - x, corner.pixel[1] - 0.5 - y);
        worst = worst.max(dx.hypot(dy));
        mean = [mean[0] + dx / 24.0, mean[1] + dy / 24.0];
    }
    println!("{} corners, the worst {worst:.3} px from OpenCV's, mean offset {mean:.3?}", found.len());
    assert!(found.len() == 24 && worst < 1.0);
}

#[test]
fn real_photos_calibrate_to_a_fifth_of_a_pixel() {
    let Some(folder) = real() else { return };
    let photos: Vec<_> = (0..4).map(|i| corners(&folder, &format!("img_0{i}.jpg")).2).collect();
    let result = calibrate(640, 480, &photos, true).unwrap();
    let each: Vec<_> = result.photos.iter().map(|photo| (photo.error, photo.largest)).collect();
    println!("{:.4} px over {:?} corners, {:?}", result.error, photos.iter().map(Vec::len).collect::<Vec<_>>(), each);
    println!("{:?} +- {:?}", result.camera, result.errors);
    assert!(result.error <= 0.20, "{}", result.error);
    // tutorial_camera_charuco.yml, in pixels; its centre is half a pixel up and left.
    for (own, theirs, k) in [(result.camera.fx, 452.5, 0), (result.camera.fy, 456.8, 1)] {
        assert!((own - theirs).abs() < 3.0 * result.errors[k], "{own} {theirs}");
    }
}

fn truth() -> Camera {
    let distortion = [-0.12, 0.08, 0.001, -0.0015, -0.02];
    Camera { width: 1280, height: 960, fx: 1100.0, fy: 1085.0, cx: 652.0, cy: 470.0, distortion, ..Camera::default() }
}

/// Corners of a 9 x 7 board from several sides, moved by `noise` pixels.
fn generated(noise: f64) -> (Vec<Pose>, Vec<Vec<Corner>>) {
    let turns = [[0.3, 0.1, 0.05], [-0.4, 0.2, 1.5], [0.1, -0.5, -0.3], [0.05, 0.45, 0.1], [-0.3, -0.35, 3.0]];
    let mut state = 1_u64;
    let mut jitter = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        noise * ((state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0)
    };
    let mut poses = Vec::new();
    let mut photos = Vec::new();
    for turn in turns {
        let rotation = Rotation3::new(Vector3::from(turn)).into_inner();
        let pose =
            Pose { rotation, translation: Vector3::new(0.0, 0.0, 0.5) - rotation * Vector3::new(0.18, 0.14, 0.0) };
        let corner = |id: u32| {
            let board = [f64::from(id % 8 + 1) * 0.04, f64::from(id / 8 + 1) * 0.04];
            let [x, y] = project(&truth(), &pose.apply(&Vector3::new(board[0], board[1], 0.0))).unwrap();
            Corner { id, board, pixel: [x + jitter(), y + jitter()] }
        };
        photos.push((0..48).map(corner).collect());
        poses.push(pose);
    }
    (poses, photos)
}

#[test]
fn exact_corners_give_their_camera_back() {
    let (poses, photos) = generated(0.0);
    let result = calibrate(1280, 960, &photos, true).unwrap();
    let (own, truth) = (&result.camera, truth());
    assert!(result.error < 1e-6, "{}", result.error);
    assert!((own.fx - truth.fx).abs() < 1e-3 && (own.cy - truth.cy).abs() < 1e-3, "{own:?}");
    assert!(own.distortion.iter().zip(truth.distortion).all(|(a, b)| (a - b).abs() < 1e-4), "{own:?}");
    for (photo, pose) in result.photos.iter().zip(poses) {
        assert!((photo.board_to_camera.translation - pose.translation).norm() < 1e-6);
    }
}

#[test]
fn noisy_corners_stay_within_their_errors() {
    let result = calibrate(1280, 960, &generated(0.5).1, true).unwrap();
    let (own, truth) = (&result.camera, truth());
    // Uniform noise of half a pixel either way: 0.41 px over both axes.
    assert!((0.35..0.45).contains(&result.error), "{}", result.error);
    for (k, (a, b)) in
        [(own.fx, truth.fx), (own.fy, truth.fy), (own.cx, truth.cx), (own.cy, truth.cy)].into_iter().enumerate()
    {
        assert!((a - b).abs() < 4.0 * result.errors[k] && result.errors[k] < 10.0, "{k}: {a} {b} {:?}", result.errors);
    }
}

#[test]
fn bad_boards_and_photos_say_how_to_mend_them() {
    for (text, says) in [
        ("5x7", "write charuco:"),
        ("charuco:5:0.04:0.02:6X6_250", "write charuco:"),
        ("charuco:1x7:0.04:0.02:6X6_250", "number of squares"),
        ("charuco:5x7:40:20:6X6_250", "if these are millimetres, write charuco:5x7:0.04:0.02:6X6_250"),
        ("chessboard:2x7:0.04", "one row of corners"),
        ("chessboard:9x7", "write chessboard:"),
        ("aruco:4x5:0.04:6X6_1000", "write aruco:"),
        ("aruco:40x5:0.04:0.01:6X6_50", "200 markers"),
        ("charuco:5x7:0.04:nan:6X6_250", "no lengths"),
        ("charuco:5x7:0.02:0.04:6X6_250", "smaller than the square"),
        ("charuco:5x7:0.04:0.02:9X9_250", "no dictionary"),
        ("charuco:50x70:0.04:0.02:6X6_250", "markers"),
    ] {
        let error = Board::parse(text).unwrap_err();
        assert!(error.contains(says), "{text}: {error}");
    }
    assert!(Board::parse(BOARD).unwrap().find(64, 48, &[128; 64 * 48]).is_empty());
    let photos = generated(0.0).1;
    assert!(calibrate(1280, 960, &photos[..2], true).unwrap_err().to_string().contains("at least 3"));
    let few = vec![photos[0].clone(), photos[1][..3].to_vec(), photos[2].clone()];
    assert!(calibrate(1280, 960, &few, true).unwrap_err().to_string().starts_with("photo 1: its 3 corners"));
    // One row of corners is a line; one direction thrice determines no focal length.
    let line = vec![photos[0][..8].to_vec(), photos[1].clone(), photos[2].clone()];
    assert!(calibrate(1280, 960, &line, true).unwrap_err().to_string().starts_with("photo 0"));
}

#[test]
fn a_frontal_board_does_not_determine_a_camera() {
    let frontal = |turn: f64, away: f64| -> Vec<Corner> {
        let rotation = Rotation3::new(Vector3::new(0.0, 0.0, turn)).into_inner();
        let pose = Pose { rotation, translation: Vector3::new(-0.1, -0.1, away) };
        let corner = |id: u32| {
            let board = [f64::from(id % 8 + 1) * 0.04, f64::from(id / 8 + 1) * 0.04];
            let pinhole = Camera { distortion: [0.0; 5], ..truth() };
            let [x, y] = project(&pinhole, &pose.apply(&Vector3::new(board[0], board[1], 0.0))).unwrap();
            // A twentieth of a pixel, in turn to either side.
            Corner { id, board, pixel: [x + 0.05 * f64::from(id % 3) - 0.05, y + 0.05 * f64::from(id % 5) - 0.1] }
        };
        (0..48).map(corner).collect()
    };
    let photos: Vec<_> =
        [(0.0, 0.5), (0.3, 0.6), (-0.4, 0.55), (1.5, 0.7)].map(|(turn, away)| frontal(turn, away)).into();
    let error = calibrate(1280, 960, &photos, true).unwrap_err().to_string();
    assert!(error.contains("do not determine"), "{error}");
}

/// A board of 5 x 6 squares of 60 pixels seen from the front, as OpenCV laid it out before 4.6: the first square is white
/// and has marker 0.
fn legacy_board() -> (u32, u32, Vec<u8>) {
    let (width, height, square) = (420_usize, 480_usize, 60_usize);
    let pixel = |index: usize| {
        let (x, y) = (index % width, index / width);
        let (Some(x), Some(y)) = (x.checked_sub(60), y.checked_sub(60)) else { return 230 };
        let (i, j) = (x / square, y / square);
        if i >= 5 || j >= 6 {
            return 230;
        }
        if (i + j) % 2 == 1 {
            return 20;
        }
        // A marker of half the square: eight cells, the outer ones black.
        let cell =
            |position: usize| (position % square).checked_sub(14).map(|inside| inside / 4).filter(|cell| *cell < 8);
        let (Some(column), Some(row)) = (cell(x), cell(y)) else { return 230 };
        if !(1..7).contains(&column) || !(1..7).contains(&row) {
            return 20;
        }
        let marker = MARKERS[(5 * j + i) / 2];
        if marker >> (35 - 6 * (row - 1) - (column - 1)) & 1 == 1 { 230 } else { 20 }
    };
    (width as u32, height as u32, (0..width * height).map(pixel).collect())
}

#[test]
fn a_board_of_before_opencv_4_6_is_found_as_such() {
    let (width, height, gray) = legacy_board();
    let modern = Board::parse("charuco:5x6:0.04:0.0213:6X6_250").unwrap();
    let found = Board::parse("charuco:5x6:0.04:0.0213:6X6_250:legacy").unwrap().find(width, height, &gray);
    assert_eq!(found.iter().map(|corner| corner.id).collect::<Vec<_>>(), (0..20).collect::<Vec<_>>());
    for corner in &found {
        for (pixel, place) in corner.pixel.iter().zip(corner.board) {
            assert!((pixel - 60.0 - place / 0.04 * 60.0).abs() < 0.5, "{corner:?}");
        }
    }
    assert_eq!(modern.legacy().unwrap().find(width, height, &gray), found);
    // Where the rows are odd, both layouts are the same.
    assert!(Board::parse(BOARD).unwrap().legacy().is_none());
    assert!(Board::parse(&format!("{BOARD}:legacy")).is_ok());
    assert!(Board::parse(&format!("{BOARD}:modern")).unwrap_err().contains(":legacy"));
}
