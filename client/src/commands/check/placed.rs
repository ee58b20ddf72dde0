//! A mesh in the world, and what can be told from its shape alone.

use super::vector::{Vector, cross, dot, length, middle, sub};
use crate::progress::count;
use gonio_scene::Capture;
use gonio_scene::capture::{Object, Photo};
use gonio_scene::mesh::Mesh;

/// Most triangles whose place in a photo is looked for.
const SAMPLE: usize = 20_000;

/// A mesh in the world.
pub(super) struct Placed<'a> {
    pub object: &'a Object,
    pub mesh: &'a Mesh,
    points: Vec<Vector>,
    mirrored: bool,
    bounds: (Vector, Vector),
}

impl<'a> Placed<'a> {
    /// `mesh` where `object` puts it.
    pub fn new(object: &'a Object, mesh: &'a Mesh) -> Self {
        let m = &object.placement();
        let place = |p: &[f32; 3]| {
            let p = p.map(f64::from);
            std::array::from_fn(|i| m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3])
        };
        let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
        let mirrored = dot(cross(column(0), column(1)), column(2)) < 0.0;
        let points: Vec<Vector> = mesh.positions.iter().map(place).collect();
        let empty = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let corners = mesh.triangles.iter().flatten().filter_map(|&index| points.get(index as usize));
        let bounds = corners.fold(empty, |(low, high), point| {
            (std::array::from_fn(|i| low[i].min(point[i])), std::array::from_fn(|i| high[i].max(point[i])))
        });
        Self { object, mesh, points, mirrored, bounds }
    }

    /// Smallest and largest coordinates of its triangles.
    pub fn bounds(&self) -> (Vector, Vector) {
        self.bounds
    }

    /// Its triangles, counter-clockwise seen from outside: as in the renderer, a pose that mirrors turns the winding, so that
    /// what is outside stays outside.
    fn triangles(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        let corner = |index: u32| self.points.get(index as usize).copied().unwrap_or([0.0; 3]);
        self.mesh.triangles.iter().map(move |triangle| {
            let [a, b, c] = triangle.map(corner);
            if self.mirrored { [a, c, b] } else { [a, b, c] }
        })
    }

    /// Whether a surface that looks outward closes around `point`: its winding number there, the solid angle of all its
    /// triangles (Van Oosterom and Strackee 1983) over 4 pi, is nearer to 1 than to 0.
    pub fn holds(&self, point: Vector) -> bool {
        let (low, high) = self.bounds;
        if (0..3).any(|axis| !(low[axis]..=high[axis]).contains(&point[axis])) {
            return false;
        }
        let solid_angle = |triangle: [Vector; 3]| {
            let [a, b, c] = triangle.map(|corner| sub(corner, point));
            let [la, lb, lc] = [a, b, c].map(length);
            let volume = dot(a, cross(b, c));
            2.0 * libm::atan2(volume, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
        };
        self.triangles().map(solid_angle).sum::<f64>() > 2.0 * std::f64::consts::PI
    }

    /// Whether a vertex, or the middle of a triangle, projects into the photo. Distortion is left aside: it hides nothing
    /// whole.
    pub fn is_in_view(&self, capture: &Capture, photo: &Photo) -> bool {
        let camera = capture.camera_of(photo);
        let (rotation, eye) = (&photo.pose(), eye(photo));
        let inside = |point: Vector| {
            let d = sub(point, eye);
            let [x, y, z] = std::array::from_fn(|j| (0..3).map(|i| rotation[i][j] * d[i]).sum::<f64>());
            let (u, v) = (camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy);
            z > 0.0 && (0.0..f64::from(camera.width)).contains(&u) && (0.0..f64::from(camera.height)).contains(&v)
        };
        let step = self.mesh.triangles.len().div_ceil(SAMPLE).max(1);
        self.triangles().step_by(step).any(|t| t.into_iter().any(inside) || inside(middle(&t)))
            // A large plane may fill the picture while its vertices lie outside of it.
            || self.triangles().step_by(step).any(|t| centre_ray_hits(&t, eye, rotation))
    }

    /// Whether its pose turns left into right.
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// Share of the triangles whose vertex normals point away from the side that their winding says is outside.
    pub fn against_vertex_normals(&self) -> f64 {
        let Some(normals) = &self.mesh.normals else { return 0.0 };
        let corner = |index: &u32| self.mesh.positions.get(*index as usize).map_or([0.0; 3], |p| p.map(f64::from));
        let normal = |index: &u32| normals.get(*index as usize).map_or([0.0; 3], |n| n.map(f64::from));
        let against = |triangle: &&[u32; 3]| {
            let [a, b, c] = triangle.each_ref().map(corner);
            let sum = triangle.iter().map(normal).fold([0.0; 3], |s, n| [s[0] + n[0], s[1] + n[1], s[2] + n[2]]);
            dot(cross(sub(b, a), sub(c, a)), sum) < 0.0
        };
        let against = self.mesh.triangles.iter().filter(against).count();
        count(against as u64) / count(self.mesh.triangles.len() as u64).max(1.0)
    }

    /// Signed over unsigned volume that the triangles span with the middle of the bounding box.
    pub fn outwardness(&self) -> f64 {
        let (low, high) = self.bounds();
        let centre: Vector = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
        let (mut signed, mut unsigned) = (0.0, 0.0);
        for [a, b, c] in self.triangles() {
            let volume = dot(sub(a, centre), cross(sub(b, centre), sub(c, centre)));
            signed += volume;
            unsigned += volume.abs();
        }
        if unsigned > 0.0 { signed / unsigned } else { 0.0 }
    }

    /// Share of the area that faces `eye`.
    pub fn facing(&self, eye: Vector) -> f64 {
        let (mut front, mut all) = (0.0, 0.0);
        for t in self.triangles() {
            let normal = cross(sub(t[1], t[0]), sub(t[2], t[0]));
            let area = length(normal);
            all += area;
            if dot(normal, sub(eye, middle(&t))) > 0.0 {
                front += area;
            }
        }
        if all > 0.0 { front / all } else { 1.0 }
    }
}

/// Where the photo was taken from.
pub(super) fn eye(photo: &Photo) -> Vector {
    photo.pose().map(|row| row[3]).first_chunk().copied().unwrap_or_default()
}

/// Whether the camera's axis meets the triangle (Moller and Trumbore 1997).
fn centre_ray_hits([a, b, c]: &[Vector; 3], eye: Vector, rotation: &[[f64; 4]; 4]) -> bool {
    let axis = [rotation[0][2], rotation[1][2], rotation[2][2]];
    let (e1, e2) = (sub(*b, *a), sub(*c, *a));
    let p = cross(axis, e2);
    let determinant = dot(e1, p);
    if determinant == 0.0 {
        return false;
    }
    let s = sub(eye, *a);
    let q = cross(s, e1);
    let (u, v, t) = (dot(s, p) / determinant, dot(axis, q) / determinant, dot(e2, q) / determinant);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0
}
