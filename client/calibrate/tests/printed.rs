//! Boards as geometry against boards as they are drawn elsewhere, and against the finder of their corners.

// Clippy lets tests unwrap, but not the functions that they share.
#![allow(clippy::unwrap_used)]
// A drawn board may differ in its last bits from machine to machine.
#![allow(clippy::disallowed_methods)]

mod drawn;
mod markers;

use gonio_calibrate::Board;
use gonio_scene::mesh::Mesh;

/// Whether a point of the board's plane (y down) lies on a mesh.
fn covers(mesh: &Mesh, [x, y]: [f64; 2]) -> bool {
    let edge = |a: [f32; 3], b: [f32; 3]| {
        let [[ax, ay], [bx, by]] = [a, b].map(|p| [f64::from(p[0]), -f64::from(p[1])]);
        (bx - ax) * (y - ay) - (by - ay) * (x - ax)
    };
    // Counter-clockwise from above is clockwise where y counts down.
    mesh.triangles.iter().any(|t| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        [edge(a, b), edge(b, c), edge(c, a)].iter().all(|side| *side <= 0.0)
    })
}

#[test]
fn a_charuco_board_is_white_and_black_where_opencv_draws_it_so() {
    let [white, black] = Board::parse("charuco:5x7:0.04:0.02:6X6_250").unwrap().meshes();
    // Off the grid of cells, 2.5 mm, so that no point is on an edge.
    for k in 0..80 * 112 {
        let at = [f64::from(k % 80) * 0.0025 + 0.0011, f64::from(k / 80) * 0.0025 + 0.0013];
        let drawn = drawn::charuco(at[0], at[1]) > 0.5;
        assert_eq!((covers(&white, at), covers(&black, at)), (drawn, !drawn), "{at:?}");
    }
    assert!(!covers(&white, [-0.001, 0.01]) && !covers(&black, [0.201, 0.01]));
}

/// Side of a cell of [`drawn_at`], metres; an edge is off by half of it at most, a twentieth of a pixel.
const STEP: f64 = 1e-4;
const SIDE: u32 = 3000;

/// The cells of the board's plane whose middles lie on a mesh of rectangles, four vertices each.
fn drawn_at(mesh: &Mesh) -> Vec<bool> {
    let mut cells = vec![false; (SIDE * SIDE) as usize];
    let cell = |metres: f32| (f64::from(metres) / STEP).round() as usize;
    for corners in mesh.positions.chunks(4) {
        let ([left, lower, _], [right, upper, _]) = (corners[0], corners[2]);
        for j in cell(-upper)..cell(-lower) {
            cells[j * SIDE as usize + cell(left)..j * SIDE as usize + cell(right)].fill(true);
        }
    }
    cells
}

#[test]
fn each_kind_of_board_is_found_where_its_geometry_is_drawn() {
    for (text, corners, middle) in [
        ("charuco:5x7:0.04:0.02:6X6_250", 24, [0.1, 0.14]),
        ("charuco:5x6:0.04:0.02:6X6_250:legacy", 20, [0.1, 0.12]),
        ("chessboard:7x6:0.04", 30, [0.14, 0.12]),
        ("aruco:4x3:0.04:0.01:4X4_50", 48, [0.095, 0.07]),
        ("apriltag:4x3:0.04:0.012:36h11", 48, [0.098, 0.07]),
    ] {
        let board = Board::parse(text).unwrap();
        let black = drawn_at(&board.meshes()[1]);
        let bright = |x: f64, y: f64| {
            let [i, j] = [x, y].map(|v| (v / STEP).floor());
            let inside = i >= 0.0 && j >= 0.0 && i < f64::from(SIDE) && j < f64::from(SIDE);
            if inside && black[j as usize * SIDE as usize + i as usize] { 0.1 } else { 0.9 }
        };
        let photo = drawn::photograph(&bright, middle, [0.1, 0.15], 0.5);
        let found = board.find(drawn::SIZE[0], drawn::SIZE[1], &photo);
        assert_eq!(found.len(), corners, "{text}");
    }
}
