//! A part as the estimator needs it.

use crate::simplify::cluster;
use glam::DVec3;
use gonio_pose::render::{self, Visible};
use gonio_pose::{Intrinsics, Pose};
use gonio_scene::mesh::Mesh;

/// Cells of the coarse mesh along the diameter: its triangles are near a pixel in pictures of [`crate::template::SIZE`].
const CELLS: f64 = 32.0;

/// A mesh with one normal per triangle.
#[derive(Debug)]
pub(crate) struct Solid {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// Outward where the mesh is wound that way; the side that is seen decides.
    normals: Vec<DVec3>,
}

/// A part: fine and coarse.
#[derive(Debug)]
pub(crate) struct Part {
    pub fine: Solid,
    pub coarse: Solid,
    /// Middle of its bounding box, model coordinates, metres.
    pub centre: DVec3,
    /// Metres.
    pub diameter: f64,
}

impl Part {
    pub fn new(mesh: &Mesh, diameter: f64) -> Self {
        let points: Vec<DVec3> = mesh.positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let (low, high) =
            points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let (means, kept) = cluster(&points, &mesh.triangles, diameter / CELLS);
        // A mesh that is coarse already would lose its shape.
        let coarse = if kept.len() * 2 < mesh.triangles.len() {
            Solid::new(means, kept)
        } else {
            Solid::new(points.clone(), mesh.triangles.clone())
        };
        let fine = Solid::new(points, mesh.triangles.clone());
        Self { fine, coarse, centre: (low + high) / 2.0, diameter }
    }

    /// The pose that turns by `rotation` and has the part's centre at `centre`, camera coordinates.
    pub fn pose(&self, rotation: glam::DMat3, centre: DVec3) -> Pose {
        Pose { rotation, translation: centre - rotation * self.centre }
    }
}

impl Solid {
    fn new(points: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let corner = |index: u32| points.get(index as usize).copied().unwrap_or(DVec3::NAN);
        // Smooth where the surface is smooth: the mean of what the corners' triangles say, unless there is an edge.
        let flat: Vec<DVec3> = triangles.iter().map(|t| t.map(corner)).map(|[a, b, c]| (b - a).cross(c - a)).collect();
        let mut at = vec![DVec3::ZERO; points.len()];
        for (triangle, normal) in triangles.iter().zip(&flat) {
            for index in triangle {
                if let Some(sum) = at.get_mut(*index as usize) {
                    *sum += *normal;
                }
            }
        }
        let smooth = |(triangle, flat): (&[u32; 3], &DVec3)| {
            let flat = flat.normalize_or_zero();
            let sum = triangle.iter().filter_map(|i| at.get(*i as usize)).map(|n| n.normalize_or_zero()).sum::<DVec3>();
            let mean = sum.normalize_or_zero();
            if mean.dot(flat) > 0.9 { mean } else { flat }
        };
        let normals = triangles.iter().zip(&flat).map(smooth).collect();
        Self { points, triangles, normals }
    }

    /// What a camera sees of it.
    pub fn see(&self, pose: &Pose, camera: &Intrinsics, width: u32, height: u32) -> Visible {
        let points: Vec<DVec3> = self.points.iter().map(|point| pose.apply(*point)).collect();
        render::visible(&points, &self.triangles, camera, width, height)
    }

    /// The normal of a triangle in camera coordinates, on the side that `ray` meets; a unit vector.
    pub fn normal(&self, triangle: u32, pose: &Pose, ray: DVec3) -> DVec3 {
        let normal = pose.rotation * self.normals.get(triangle as usize).copied().unwrap_or(DVec3::Z);
        if normal.dot(ray) > 0.0 { -normal } else { normal }
    }
}
