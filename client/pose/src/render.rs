//! Depth of a model at a pose, by a z-buffer: what VSD compares, at the centre of each pixel.

use crate::bop::Depth;
use crate::{Intrinsics, Pose};
use glam::{DVec2, DVec3};
use gonio_scene::mesh::Mesh;

/// Triangles that come nearer than this, in metres, are left out rather than clipped: no camera sees a part from there.
const NEAR: f64 = 1e-4;

/// What each pixel of a picture sees at its centre.
#[derive(Debug, Clone, PartialEq)]
pub struct Visible {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// z of the nearest surface in metres, row by row from the top; 0 where there is none.
    pub metres: Vec<f32>,
    /// Index of the triangle that is seen; [`NOTHING`] where there is none.
    pub triangles: Vec<u32>,
}

/// Stands for no triangle.
pub const NOTHING: u32 = u32::MAX;

/// z of the nearest surface of `mesh` in each of `width * height` pixels, 0 where there is none. Both sides of a triangle
/// count.
#[must_use]
pub fn depth(mesh: &Mesh, pose: &Pose, camera: &Intrinsics, width: u32, height: u32) -> Depth {
    let points: Vec<DVec3> = mesh.positions.iter().map(|p| pose.apply(DVec3::from_array(p.map(f64::from)))).collect();
    let Visible { metres, .. } = visible(&points, &mesh.triangles, camera, width, height);
    Depth { width, height, metres }
}

/// What a picture of `width * height` pixels sees of `triangles` between `points`, which are in camera coordinates, metres.
/// Both sides of a triangle count.
#[must_use]
pub fn visible(points: &[DVec3], triangles: &[[u32; 3]], camera: &Intrinsics, width: u32, height: u32) -> Visible {
    let count = width as usize * height as usize;
    let mut seen = Visible { width, height, metres: vec![0.0; count], triangles: vec![NOTHING; count] };
    // Column, row and 1 / z, which is linear over the image; z above 0 marks what may be seen.
    let project =
        |point: &DVec3| if point.z > NEAR { camera.project(*point).extend(1.0 / point.z) } else { DVec3::NAN };
    let projected: Vec<DVec3> = points.iter().map(project).collect();
    for (number, triangle) in triangles.iter().enumerate() {
        let corners = triangle.map(|index| projected.get(index as usize).copied().unwrap_or(DVec3::NAN));
        #[allow(clippy::cast_possible_truncation)] // a mesh has fewer than 2^32
        seen.fill(number as u32, &corners);
    }
    seen
}

impl Visible {
    fn fill(&mut self, number: u32, corners: &[DVec3; 3]) {
        let [a, b, c] = corners.map(DVec3::truncate);
        let area = cross(b - a, c - a);
        if !area.is_finite() || area == 0.0 {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let (rows, columns) = (pixels(low.y, high.y, self.height), pixels(low.x, high.x, self.width));
        let Some(first) = columns.clone().next() else { return };
        // Weights of the corners, and how they change from column to column.
        let across = [c - b, a - c, b - a].map(|side| -side.y / area);
        let inverse = across.iter().zip(corners).map(|(step, corner)| step * corner.z).sum::<f64>();
        for row in rows {
            let pixel = DVec2::new(f64::from(first), f64::from(row));
            let begin = [cross(c - b, pixel - b), cross(a - c, pixel - c), cross(b - a, pixel - a)].map(|w| w / area);
            let nearness = begin.iter().zip(corners).map(|(weight, corner)| weight * corner.z).sum::<f64>();
            for column in columns.clone() {
                let steps = f64::from(column - first);
                if begin.iter().zip(across).any(|(begin, across)| begin + steps * across < 0.0) {
                    continue;
                }
                #[allow(clippy::cast_possible_truncation)]
                let z = (1.0 / (nearness + steps * inverse)) as f32;
                let index = row as usize * self.width as usize + column as usize;
                if let (Some(old), Some(triangle)) = (self.metres.get_mut(index), self.triangles.get_mut(index))
                    && (*old == 0.0 || z < *old)
                {
                    (*old, *triangle) = (z, number);
                }
            }
        }
    }
}

/// The pixels, of `size`, whose centres lie from `low` to `high`.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // `as` saturates, and the ends are inside the image
fn pixels(low: f64, high: f64, size: u32) -> std::ops::Range<u32> {
    let (low, high) = (low.max(0.0), high.min(f64::from(size) - 1.0));
    if low > high {
        return 0..0;
    }
    // No call of ceil and floor: a mesh has more triangles than a picture pixels.
    let first = low as u32;
    let first = if f64::from(first) < low { first + 1 } else { first };
    first..high as u32 + 1
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
