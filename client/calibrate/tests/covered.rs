//! Boards half covered by what stands on them, and corners that are wrong: the camera comes back, and who was dropped is said.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_calibrate::{Corner, Pose, calibrate, locate, project};
use gonio_scene::capture::Camera;
use nalgebra::{Rotation3, Vector3};

/// Standard deviation of a corner along one axis, pixels: on rendered photographs of a part, the finder leaves 0.04.
const NOISE: f64 = 0.05;

/// Knuth's MMIX generator; its upper bits.
struct Draw(u64);

impl Draw {
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 33) as f64 / f64::from(1_u32 << 31)
    }

    fn gauss(&mut self) -> f64 {
        // Twelve uniform numbers have variance 1.
        (0..12).map(|_| self.uniform(-0.5, 0.5)).sum()
    }
}

fn camera(draw: &mut Draw) -> Camera {
    let focal = draw.uniform(1000.0, 1600.0);
    let k1 = draw.uniform(-0.2, 0.1);
    // Every second lens is one without distortion.
    let distortion = if draw.uniform(0.0, 1.0) < 0.5 { [0.0; 5] } else { [k1, draw.uniform(-0.1, 0.1), 0.0, 0.0, 0.0] };
    let (cx, cy) = (draw.uniform(620.0, 660.0), draw.uniform(460.0, 500.0));
    Camera { width: 1280, height: 960, fx: focal, fy: focal, cx, cy, distortion, ..Camera::default() }
}

/// A photo of a board of 9 x 7 squares of 40 mm, of whose 48 corners a part hides a half: those nearest to where it stands.
fn photo(draw: &mut Draw, camera: &Camera) -> (Pose, Vec<Corner>) {
    let tilt = Rotation3::new(Vector3::new(draw.uniform(0.4, 0.9), 0.0, 0.0));
    let turn = Rotation3::new(Vector3::new(0.0, 0.0, draw.uniform(-3.1, 3.1)));
    let roll = Rotation3::new(Vector3::new(0.0, 0.0, draw.uniform(-0.3, 0.3)));
    let rotation = (roll * tilt * turn).into_inner();
    let away = camera.fx / 1280.0 * draw.uniform(0.45, 0.6);
    let aside = Vector3::new(draw.uniform(-0.03, 0.03), draw.uniform(-0.03, 0.03), away);
    let pose = Pose { rotation, translation: aside - rotation * Vector3::new(0.18, 0.14, 0.0) };
    let part = [draw.uniform(0.1, 0.26), draw.uniform(0.08, 0.2)];
    let mut corners = Vec::new();
    for id in 0..48 {
        let board = [f64::from(id % 8 + 1) * 0.04, f64::from(id / 8 + 1) * 0.04];
        let [x, y] = project(camera, &pose.apply(&Vector3::new(board[0], board[1], 0.0))).unwrap();
        corners.push(Corner { id, board, pixel: [x + NOISE * draw.gauss(), y + NOISE * draw.gauss()] });
    }
    let distance = |corner: &Corner| (corner.board[0] - part[0]).hypot(corner.board[1] - part[1]);
    corners.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
    corners.truncate(24);
    // The part's edge passes for a corner.
    corners[23].pixel[0] += draw.uniform(1.0, 4.0);
    corners.retain(|corner| (0.0..1280.0).contains(&corner.pixel[0]) && (0.0..960.0).contains(&corner.pixel[1]));
    (pose, corners)
}

#[test]
fn half_covered_boards_give_the_focal_length_to_a_thousandth() {
    let mut within = 0;
    for seed in 0..20 {
        let mut draw = Draw(seed);
        let camera = camera(&mut draw);
        let photos: Vec<Vec<Corner>> = (0..12).map(|_| photo(&mut draw, &camera).1).collect();
        let result = calibrate(1280, 960, &photos, true).unwrap();
        let off = (result.camera.fx / camera.fx - 1.0).abs().max((result.camera.fy / camera.fy - 1.0).abs());
        let (own, distortion) = (result.model, result.model.distortion());
        println!(
            "seed {seed}: focal length off by {:.4} % (+- {:.4} %), {:.3} px, {distortion}, square {}, truth {:?}",
            100.0 * off,
            100.0 * result.errors[0] / camera.fx,
            result.error,
            own.square,
            camera.distortion,
        );
        within += u32::from(off < 1e-3);
    }
    assert!(within >= 19, "{within} of 20");
}

#[test]
fn what_contradicts_the_others_is_dropped_and_named() {
    let mut draw = Draw(100);
    let camera = Camera { distortion: [0.0; 5], ..camera(&mut draw) };
    let mut shots: Vec<(Pose, Vec<Corner>)> = (0..8).map(|_| photo(&mut draw, &camera)).collect();
    // A corner taken for another one, forty pixels off.
    let wrong = shots[2].1[5].id;
    shots[2].1[5].pixel[1] += 40.0;
    // A photo with another zoom.
    let zoomed = Camera { fx: 1.3 * camera.fx, fy: 1.2 * camera.fy, ..camera.clone() };
    shots[6] = photo(&mut draw, &zoomed);
    let photos: Vec<Vec<Corner>> = shots.iter().map(|(_, corners)| corners.clone()).collect();
    let result = calibrate(1280, 960, &photos, false).unwrap();
    let near = |calibrated: &Camera| (calibrated.fx / camera.fx - 1.0).abs() < 2e-3;
    assert!(near(&result.camera) && result.camera.distortion == [0.0; 5], "{result:?}");
    for (index, fit) in result.photos.iter().enumerate() {
        assert_eq!(fit.corners == 0, index == 6, "{index}: {fit:?}");
        if index != 6 {
            // The part's edge, at least; and hardly a corner besides.
            assert!((1..4).contains(&fit.dropped.len()), "{index}: {fit:?}");
            assert!((fit.board_to_camera.translation - shots[index].0.translation).norm() < 2e-3, "{index}");
        }
    }
    assert!(result.photos[2].dropped.iter().any(|(id, off)| *id == wrong && *off > 39.0), "{:?}", result.photos[2]);

    // With the camera known, photos stand alone.
    let known = locate(&camera, &photos[2..3]).unwrap();
    assert!(known.camera == camera && known.left_out.is_none() && known.errors == [0.0; 9]);
    assert!(known.photos[0].dropped.iter().any(|(id, _)| *id == wrong));
    assert!((known.photos[0].board_to_camera.translation - shots[2].0.translation).norm() < 5e-4);
    assert_eq!(locate(&camera, &[photos[0][..3].to_vec()]).unwrap_err().photo, Some(0));
}
