//! Parts in pictures that the test draws itself: a block with two unequal arms, Lambertian under two lamps on a table of
//! another colour, with noise. The drawing shares the z-buffer with the estimator, and not its model of shading: one lamp's
//! cosine is cut off at 0, which no quadratic of the normal is.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use glam::{DMat3, DVec3};
use gonio_estimate::{Estimator, Settings};
use gonio_pose::bop::Model;
use gonio_pose::errors::Shape;
use gonio_pose::render::{NOTHING, visible};
use gonio_pose::{Intrinsics, Pose};
use gonio_scene::image::Image;
use gonio_scene::mesh::Mesh;

const CAMERA: Intrinsics = Intrinsics { fx: 300.0, fy: 300.0, cx: 99.5, cy: 74.5 };
const SIZE: (u32, u32) = (200, 150);

/// Boxes from one corner to the other, metres.
const BOXES: [[[f32; 3]; 2]; 3] = [
    [[-0.03, -0.02, 0.0], [0.03, 0.02, 0.02]],
    [[-0.03, -0.02, 0.02], [-0.01, 0.0, 0.06]],
    [[0.03, -0.01, 0.0], [0.055, 0.01, 0.01]],
];

fn part() -> Model {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for [low, high] in BOXES {
        for axis in 0..3 {
            for side in [low, high] {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let first = u32::try_from(positions.len()).unwrap();
                for (a, b) in [(low, low), (high, low), (high, high), (low, high)] {
                    let mut corner = side;
                    (corner[u], corner[v]) = (a[u], b[v]);
                    positions.push(corner);
                }
                triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            }
        }
    }
    let mesh = Mesh { positions, normals: None, triangles, degenerate: 0 };
    let points: Vec<DVec3> = mesh.positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
    let diameter = gonio_pose::bop::diameter(&points);
    Model { mesh, diameter, discrete: Vec::new(), continuous: Vec::new() }
}

/// A picture of the part in `colour`; everything follows from `seed`.
fn picture(model: &Model, pose: &Pose, colour: [f32; 3], seed: u64) -> Image {
    let points: Vec<DVec3> =
        model.mesh.positions.iter().map(|p| pose.apply(DVec3::from_array(p.map(f64::from)))).collect();
    let seen = visible(&points, &model.mesh.triangles, &CAMERA, SIZE.0, SIZE.1);
    let mut state = seed;
    let mut noise = || {
        let mut sum = -6.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += f64::from((state >> 40) as u32) / f64::from(1 << 24);
        }
        (0.01 * sum) as f32
    };
    let lamps = [(DVec3::new(-0.5, -0.7, -0.5).normalize(), 0.5), (DVec3::new(0.8, -0.1, -0.6).normalize(), 0.25)];
    let pixels = seen.triangles.iter().map(|&triangle| {
        let value = if triangle == NOTHING {
            [0.55, 0.53, 0.5]
        } else {
            let [a, b, c] = model.mesh.triangles[triangle as usize].map(|i| points[i as usize]);
            let normal = (b - a).cross(c - a).normalize();
            let normal = if normal.dot(a) > 0.0 { -normal } else { normal };
            let light: f64 = 0.35 + lamps.iter().map(|(way, power)| power * normal.dot(*way).max(0.0)).sum::<f64>();
            colour.map(|c| c * light as f32)
        };
        value.map(|v| (v + noise()).clamp(0.0, 1.0))
    });
    Image { width: SIZE.0, height: SIZE.1, pixels: pixels.collect() }
}

/// Poses from all sides, somewhere in the picture.
fn poses(count: u32) -> Vec<Pose> {
    let turn = |index: u32| {
        let t = f64::from(index);
        let elevation = 0.5 + 0.9 * ((0.618 * t) % 1.0);
        let tilt = DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2 + elevation);
        let rotation = tilt * DMat3::from_rotation_z(2.4 * t);
        let place = CAMERA.ray(70.0 + 60.0 * ((0.755 * t) % 1.0), 60.0 + 30.0 * ((0.57 * t) % 1.0));
        Pose { rotation, translation: place * (0.28 + 0.1 * ((0.43 * t) % 1.0)) }
    };
    (0..count).map(turn).collect()
}

#[test]
fn a_part_is_found_from_all_sides() {
    let model = part();
    let (shape, estimator) = (Shape::new(&model), Estimator::new(&model));
    let mut errors = Vec::new();
    for (index, pose) in poses(10).iter().enumerate() {
        let image = picture(&model, pose, [0.5, 0.25, 0.15], index as u64 + 1);
        let found = estimator.find(&image, &CAMERA, &Settings::default());
        let error = found.first().map_or(f64::INFINITY, |first| shape.mssd(&first.pose, pose) / model.diameter);
        errors.push(error);
    }
    errors.sort_by(f64::total_cmp);
    // Measured: all ten below 0.05, half of them below 0.028.
    assert!(errors[8] < 0.1 && errors[4] < 0.04, "{errors:?}");
}

#[test]
fn the_same_image_gives_the_same_bits() {
    let model = part();
    let estimator = Estimator::new(&model);
    let pose = poses(3)[2];
    let image = picture(&model, &pose, [0.2, 0.3, 0.5], 9);
    let settings = Settings { distance: Some([0.25, 0.45]) };
    let first = estimator.find(&image, &CAMERA, &settings);
    assert!(!first.is_empty());
    assert_eq!(first, estimator.find(&image, &CAMERA, &settings));
    assert!(first.windows(2).all(|pair| pair[0].score >= pair[1].score));
}

#[test]
fn an_image_smaller_than_a_template_holds_nothing() {
    let estimator = Estimator::new(&part());
    let image = Image { width: 3, height: 2, pixels: vec![[0.5; 3]; 6] };
    assert!(estimator.find(&image, &CAMERA, &Settings::default()).is_empty());
}
