//! Meshes and where they are.

use crate::progress::count;
use gonio_scene::capture::{Object, Photo};
use gonio_scene::files::Files;
use gonio_scene::mesh::{self, Mesh};
use gonio_scene::{Capture, SceneError};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// An object smaller than its distance to the nearest camera over this, or larger than its distance times this, is suspicious.
const DISPROPORTION: f64 = 500.0;
/// Share of the area that must turn to some camera.
const FACING: f64 = 0.02;
/// A closed surface whose normals point inward has -1 here, one that is right +1, an open one about 0.
const INWARD: f64 = -0.3;
/// Most triangles and vertices looked at one by one.
const SAMPLE: usize = 20_000;

/// One object.
#[derive(Debug, Serialize)]
pub(super) struct ObjectSummary {
    pub name: String,
    pub mesh: String,
    pub material: String,
    pub triangles: usize,
    /// Triangles of the file that have no area and were left out.
    pub degenerate: usize,
    /// Whether the file has vertex normals.
    pub normals: bool,
    /// Sides of the bounding box along the world's axes, in metres.
    pub extent: [f64; 3],
    /// Photos that it is in view of, by its vertices.
    pub photos: usize,
}

type Vector = [f64; 3];

/// Looks at every mesh, and whether cameras can see it.
pub(super) fn look(
    capture: &Capture,
    files: &dyn Files,
    errors: &mut Vec<SceneError>,
    warnings: &mut Vec<String>,
) -> Vec<ObjectSummary> {
    let mut meshes: BTreeMap<&str, Option<Arc<Mesh>>> = BTreeMap::new();
    let mut summaries = Vec::new();
    let mut seen = vec![false; capture.photos.len()];
    let mut all_read = true;
    for object in &capture.objects {
        let mesh = meshes.entry(&object.mesh).or_insert_with(|| match mesh::read(files, &object.mesh) {
            Ok(mesh) => Some(Arc::new(mesh)),
            Err(error) => {
                errors.push(error);
                None
            }
        });
        let Some(mesh) = mesh else {
            all_read = false;
            continue;
        };
        let placed = Placed::new(object, mesh);
        let summary = placed.summarise(capture, &mut seen);
        placed.warn(capture, &summary, warnings);
        summaries.push(summary);
    }
    if capture.objects.is_empty() {
        warnings.push("capture.toml: object: there is none, so that nothing but lights can be seen".to_owned());
    } else if all_read {
        for (photo, _) in capture.photos.iter().zip(&seen).filter(|(_, seen)| !**seen) {
            warnings.push(format!(
                "capture.toml: photo.{}.camera_to_world: no object is in view; is it world-to-camera, or of another axis convention?",
                photo.name()
            ));
        }
    }
    summaries
}

/// A mesh in the world.
struct Placed<'a> {
    object: &'a Object,
    mesh: &'a Mesh,
    points: Vec<Vector>,
}

impl<'a> Placed<'a> {
    fn new(object: &'a Object, mesh: &'a Mesh) -> Self {
        let m = &object.object_to_world;
        let place = |p: &[f32; 3]| {
            let p = p.map(f64::from);
            std::array::from_fn(|i| m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3])
        };
        Self { object, mesh, points: mesh.positions.iter().map(place).collect() }
    }

    fn summarise(&self, capture: &Capture, seen: &mut [bool]) -> ObjectSummary {
        let (low, high) = self.bounds();
        let mut photos = 0;
        for (photo, seen) in capture.photos.iter().zip(seen) {
            if self.is_in_view(capture, photo) {
                *seen = true;
                photos += 1;
            }
        }
        ObjectSummary {
            name: self.object.name.clone(),
            mesh: self.object.mesh.clone(),
            material: self.object.material.clone(),
            triangles: self.mesh.triangles.len(),
            degenerate: self.mesh.degenerate,
            normals: self.mesh.normals.is_some(),
            extent: std::array::from_fn(|i| high[i] - low[i]),
            photos,
        }
    }

    fn bounds(&self) -> (Vector, Vector) {
        let mut bounds = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in self.triangles().flatten() {
            for i in 0..3 {
                bounds.0[i] = bounds.0[i].min(point[i]);
                bounds.1[i] = bounds.1[i].max(point[i]);
            }
        }
        bounds
    }

    fn triangles(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        let corner = |index: u32| self.points.get(index as usize).copied().unwrap_or([0.0; 3]);
        self.mesh.triangles.iter().map(move |triangle| triangle.map(corner))
    }

    /// Whether a vertex, or the middle of a triangle, projects into the photo. Distortion is left aside: it hides nothing
    /// whole.
    fn is_in_view(&self, capture: &Capture, photo: &Photo) -> bool {
        let camera = capture.camera_of(photo);
        let (rotation, eye) = (&photo.camera_to_world, eye(photo));
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

    fn warn(&self, capture: &Capture, summary: &ObjectSummary, warnings: &mut Vec<String>) {
        let (name, mesh) = (&self.object.name, &self.object.mesh);
        if summary.degenerate > 0 {
            warnings.push(format!("{mesh}: {} triangles without an area were left out", summary.degenerate));
        }
        if summary.photos == 0 {
            warnings.push(format!("capture.toml: object.{name}: no photo has it in view; is its pose right?"));
        }
        let (low, high) = self.bounds();
        let extent = summary.extent.iter().copied().fold(0.0, f64::max);
        let centre: Vector = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
        let nearest = capture.photos.iter().map(|p| length(sub(eye(p), centre))).fold(f64::INFINITY, f64::min);
        if extent * DISPROPORTION < nearest || extent > nearest.max(1e-12) * DISPROPORTION {
            warnings.push(format!(
                "{mesh}: object {name} is {extent:.3e} m large and the nearest camera {nearest:.3e} m away: are both in metres?"
            ));
        }
        if self.against_vertex_normals() > 0.5 {
            warnings.push(format!(
                "{mesh}: the vertex normals point against the faces' winding: flip one of the two in the file"
            ));
        }
        let inward = self.outwardness() < INWARD;
        if inward {
            warnings
                .push(format!("{mesh}: the faces of object {name} point inward: flip their winding{}", self.mirror()));
        } else if capture.photos.iter().all(|photo| self.facing(eye(photo)) < FACING) {
            warnings.push(format!(
                "{mesh}: object {name} turns its back to every camera, and a back is black: flip its winding{}",
                self.mirror()
            ));
        }
    }

    fn mirror(&self) -> &'static str {
        let m = &self.object.object_to_world;
        let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
        if dot(cross(column(0), column(1)), column(2)) < 0.0 { " (its object_to_world mirrors)" } else { "" }
    }

    /// Share of the triangles whose vertex normals point away from the side that their winding says is outside.
    fn against_vertex_normals(&self) -> f64 {
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
    fn outwardness(&self) -> f64 {
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
    fn facing(&self, eye: Vector) -> f64 {
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
fn eye(photo: &Photo) -> Vector {
    photo.camera_to_world.map(|row| row[3]).first_chunk().copied().unwrap_or_default()
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

fn middle(t: &[Vector; 3]) -> Vector {
    std::array::from_fn(|i| (t[0][i] + t[1][i] + t[2][i]) / 3.0)
}

fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}
