//! Depth of a model at a pose, by a z-buffer: what VSD compares, at the centre of each pixel.

use crate::bop::Depth;
use crate::{Intrinsics, Pose};
use glam::{DVec2, DVec3};
use gonio_scene::mesh::Mesh;

/// Triangles that come nearer than this, in metres, are left out rather than clipped: no camera sees a part from there.
const NEAR: f64 = 1e-4;

/// z of the nearest surface of `mesh` in each of `width * height` pixels, 0 where there is none. Both sides of a triangle
/// count.
#[must_use]
pub fn depth(mesh: &Mesh, pose: &Pose, camera: &Intrinsics, width: u32, height: u32) -> Depth {
    let mut metres = vec![0f32; width as usize * height as usize];
    let points: Vec<DVec3> = mesh.positions.iter().map(|p| pose.apply(DVec3::from_array(p.map(f64::from)))).collect();
    for triangle in &mesh.triangles {
        let corners = triangle.map(|index| points.get(index as usize).copied().unwrap_or(DVec3::NAN));
        if corners.iter().all(|corner| corner.z > NEAR) {
            fill(&corners, camera, width, height, &mut metres);
        }
    }
    Depth { width, height, metres }
}

fn fill(corners: &[DVec3; 3], camera: &Intrinsics, width: u32, height: u32, metres: &mut [f32]) {
    let [a, b, c] = corners.map(|corner| camera.project(corner));
    let area = cross(b - a, c - a);
    if !area.is_finite() || area == 0.0 {
        return;
    }
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    // Out of view gives an empty range: `as` saturates.
    #[allow(clippy::cast_possible_truncation)]
    let range =
        |low: f64, high: f64, size: u32| low.ceil().max(0.0) as i64..=high.floor().min(f64::from(size) - 1.0) as i64;
    // 1 / z is linear over the image.
    let inverse = corners.map(|corner| 1.0 / corner.z);
    for row in range(low.y, high.y, height) {
        for column in range(low.x, high.x, width) {
            #[allow(clippy::cast_precision_loss)]
            let pixel = DVec2::new(column as f64, row as f64);
            let weights = [cross(c - b, pixel - b), cross(a - c, pixel - c), cross(b - a, pixel - a)].map(|w| w / area);
            if weights.iter().any(|&weight| weight < 0.0) {
                continue;
            }
            let z = 1.0 / weights.iter().zip(inverse).map(|(weight, inverse)| weight * inverse).sum::<f64>();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // inside the image
            let index = row as usize * width as usize + column as usize;
            #[allow(clippy::cast_possible_truncation)]
            let z = z as f32;
            if let Some(old) = metres.get_mut(index)
                && (*old == 0.0 || z < *old)
            {
                *old = z;
            }
        }
    }
}

fn cross(a: DVec2, b: DVec2) -> f64 {
    a.x * b.y - a.y * b.x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slanted_plane_has_the_depth_of_the_ray_that_meets_it() {
        // z = 0.5 + 0.4 x, crossed by x = z (u - cx) / fx.
        let at = |x: f32, y: f32| [x, y, 0.5 + 0.4 * x];
        let positions = vec![at(-0.1, -0.1), at(0.1, -0.1), at(0.1, 0.1), at(-0.1, 0.1)];
        let mesh = Mesh { positions, normals: None, triangles: vec![[0, 1, 2], [0, 3, 2]], degenerate: 0 };
        let camera = Intrinsics { fx: 100.0, fy: 120.0, cx: 19.5, cy: 15.0 };
        let depth = depth(&mesh, &Pose::IDENTITY, &camera, 40, 30);
        let mut seen = 0;
        for row in 0..30u32 {
            for column in 0..40u32 {
                let ray = camera.ray(f64::from(column), f64::from(row));
                let z = 0.5 / (1.0 - 0.4 * ray.x);
                let inside = (z * ray.x).abs() < 0.1 && (z * ray.y).abs() < 0.1;
                let found = f64::from(depth.metres[(row * 40 + column) as usize]);
                assert!((found - if inside { z } else { 0.0 }).abs() < 1e-6, "{column} {row}: {found} {z}");
                seen += u32::from(inside);
            }
        }
        assert!(seen > 500);
    }

    #[test]
    fn the_nearer_surface_hides_the_other_and_what_is_behind_is_not_seen() {
        let square = |z: f32| [[-1.0, -1.0, z], [3.0, -1.0, z], [-1.0, 3.0, z]];
        let positions = [square(2.0), square(1.0), square(-1.0)].concat();
        let mesh = Mesh { positions, normals: None, triangles: vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]], degenerate: 0 };
        let camera = Intrinsics { fx: 10.0, fy: 10.0, cx: 2.0, cy: 2.0 };
        assert_eq!(depth(&mesh, &Pose::IDENTITY, &camera, 5, 5).metres, [1.0; 25]);
    }
}
