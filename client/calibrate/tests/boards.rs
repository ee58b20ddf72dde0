//! Boards of every kind in drawn photographs, whole and half covered, and what is said of others; the real grid of markers in
//! the folder that `GONIO_REAL` names or in `../shared/real` beside the checkout (skipped where there is none).

#![allow(clippy::unwrap_used, clippy::disallowed_methods)] // a test fails by panicking, and no film is shaped here

mod drawn;
mod markers;

use drawn::{FOCAL, SIZE, axes, charuco, marker, photograph};
use gonio_calibrate::{Board, Corner, calibrate};
use std::path::PathBuf;

const TURNS: [[f64; 2]; 5] = [[0.5, 0.1], [-0.45, 0.2], [0.1, -0.5], [0.2, 0.45], [-0.4, -0.4]];

fn find(board: &str, gray: &[u8]) -> Vec<Corner> {
    Board::parse(board).unwrap().find(SIZE[0], SIZE[1], gray)
}

/// Where a point of the board falls, pixels.
fn seen([x, y]: [f64; 2], middle: [f64; 2], turn: [f64; 2], distance: f64) -> [f64; 2] {
    let [along_x, along_y] = axes(turn);
    let at: [f64; 3] = std::array::from_fn(|k| {
        (x - middle[0]) * along_x[k] + (y - middle[1]) * along_y[k] + if k == 2 { distance } else { 0.0 }
    });
    [FOCAL * at[0] / at[2] + 320.0, FOCAL * at[1] / at[2] + 240.0]
}

/// The corners of a board in five photographs, which must lie within `off` pixels of the truth, and give the camera back.
fn calibrates(text: &str, board: &dyn Fn(f64, f64) -> f64, middle: [f64; 2], count: usize, off: f64) {
    let mut photos = Vec::new();
    for turn in TURNS {
        let corners = find(text, &photograph(board, middle, turn, 0.42));
        assert_eq!(corners.len(), count, "{text} {turn:?}");
        for corner in &corners {
            let [x, y] = seen(corner.board, middle, turn, 0.42);
            let far = (corner.pixel[0] - x).hypot(corner.pixel[1] - y);
            assert!(far < off, "{text} {turn:?}: {corner:?} is {far} px from {x} {y}");
        }
        photos.push(corners);
    }
    let result = calibrate(SIZE[0], SIZE[1], &photos, true).unwrap();
    println!("{text}: fx {} +- {}, {:.4} px", result.camera.fx, result.errors[0], result.error);
    assert!((result.camera.fx / FOCAL - 1.0).abs() < 5e-3 && result.model.square, "{result:?}");
}

fn squares(x: f64, y: f64) -> f64 {
    let (u, v) = ((x / 0.025).floor(), (y / 0.025).floor());
    let black = (0.0..10.0).contains(&u) && (0.0..7.0).contains(&v) && (u + v) % 2.0 == 0.0;
    if black { 0.1 } else { 0.9 }
}

#[test]
fn a_chessboard_calibrates() {
    calibrates("chessboard:10x7:0.025", &squares, [0.125, 0.0875], 54, 0.3);
    let gray = photograph(&squares, [0.125, 0.0875], TURNS[0], 0.42);
    let counted = Board::parse("chessboard:9x6:0.025").unwrap();
    assert!(counted.find(SIZE[0], SIZE[1], &gray).is_empty() && !counted.turns_unseen());
    let sighting = counted.sighting(SIZE[0], SIZE[1], &gray);
    assert_eq!(sighting.fits.as_deref(), Some("chessboard:10x7:0.025"), "{sighting:?}");
    assert!(Board::parse("chessboard:9x7:0.025").unwrap().turns_unseen());
}

/// A grid of 4 x 4 markers of 40 mm, 10 mm apart.
fn grid(x: f64, y: f64) -> f64 {
    let (u, v) = (x / 0.05, y / 0.05);
    let (i, j) = (u.floor(), v.floor());
    let (x, y) = ((u - i) / 0.8, (v - j) / 0.8);
    let inside = (0.0..4.0).contains(&u) && (0.0..4.0).contains(&v) && x < 1.0 && y < 1.0;
    if inside { marker(4 * j as usize + i as usize, x, y) } else { 0.9 }
}

#[test]
fn a_grid_of_markers_calibrates() {
    calibrates("aruco:4x4:0.04:0.01:6X6_250", &grid, [0.095, 0.095], 64, 0.3);
    let gray = photograph(&grid, [0.095, 0.095], TURNS[2], 0.42);
    let other = Board::parse("charuco:5x7:0.04:0.02:6X6_250").unwrap().sighting(SIZE[0], SIZE[1], &gray);
    assert_eq!(other.fits.as_deref(), Some("aruco:4x4:MARKER:GAP:6X6_250"), "{other:?}");
}

#[test]
fn corners_beside_a_part_are_found_and_those_under_it_are_not() {
    let middle = [0.1, 0.14];
    for turn in TURNS {
        // A part of middle brightness covers the board's middle: 2.2 squares in radius.
        let covered = |x: f64, y: f64| if (x - 0.1).hypot(y - 0.14) < 0.088 { 0.4 } else { charuco(x, y) };
        let corners = find("charuco:5x7:0.04:0.02:6X6_250", &photograph(&covered, middle, turn, 0.42));
        // Of 24 corners, the four at the ends and some at the sides are free.
        println!("{turn:?}: {} corners", corners.len());
        assert!(corners.len() >= 8, "{turn:?}: {corners:?}");
        for corner in &corners {
            let far = (corner.board[0] - 0.1).hypot(corner.board[1] - 0.14);
            let [x, y] = seen(corner.board, middle, turn, 0.42);
            let off = (corner.pixel[0] - x).hypot(corner.pixel[1] - y);
            assert!(far > 0.08 && off < 0.3, "{turn:?}: {corner:?} is {off} px off");
        }
    }
}

#[test]
fn another_layout_is_named() {
    let gray = photograph(&charuco, [0.1, 0.14], TURNS[0], 0.42);
    for stated in ["charuco:7x5:0.04:0.02:6X6_250", "charuco:4x6:0.04:0.02:6X6_250"] {
        let sighting = Board::parse(stated).unwrap().sighting(SIZE[0], SIZE[1], &gray);
        assert_eq!(sighting.fits.as_deref(), Some("charuco:5x7:0.04:0.02:6X6_250"), "{sighting:?}");
        assert_eq!(sighting.markers, (0..17).collect::<Vec<_>>());
    }
    // A smaller dictionary of the same markers would do, too.
    let sighting = Board::parse("charuco:5x7:0.04:0.02:4X4_50").unwrap().sighting(SIZE[0], SIZE[1], &gray);
    assert_eq!(sighting.fits.as_deref(), Some("charuco:5x7:0.04:0.02:6X6_50"), "{sighting:?}");
    let stated = Board::parse("charuco:5x7:0.04:0.02:6X6_250").unwrap();
    assert_eq!(stated.sighting(SIZE[0], SIZE[1], &gray).fits, None);
    assert!(stated.sighting(64, 48, &[128; 64 * 48]).markers.is_empty());
}

#[test]
fn a_real_grid_of_markers_calibrates() {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    let folder = std::env::var_os("GONIO_REAL").map_or_else(beside, PathBuf::from).join("aruco-grid");
    if !folder.is_dir() {
        println!("skipped: no aruco-grid in GONIO_REAL or ../shared/real");
        return;
    }
    let board = Board::parse("aruco:4x5:0.0375:0.005:6X6_1000").unwrap();
    // Every fourth of them: what all say takes a minute in a build without optimisation.
    let corners = |number: u32| {
        let gray = image::open(folder.join(format!("{number}.jpg"))).unwrap().to_luma8();
        board.find(gray.width(), gray.height(), &gray)
    };
    let photos: Vec<Vec<Corner>> = (0..=40).step_by(8).map(corners).collect();
    let result = calibrate(640, 480, &photos, true).unwrap();
    println!("{:.4} px, {:?}", result.error, result.camera);
    // OpenCV: 0.92 px without, 0.47 px with its refinement of corners.
    assert!(result.error < 0.4, "{}", result.error);
}
