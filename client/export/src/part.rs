//! Objects: meshes in coordinates from which a motion leads to the world.

use crate::Result;
use crate::ledger::Ledger;
use crate::matrix::{self, Matrix, diagonal, direction};
use crate::name::Names;
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::mesh::Mesh;
use gonio_scene::{Capture, SceneError};
use std::collections::BTreeMap;
use std::sync::Arc;

/// An object that is there.
pub struct Part {
    /// A name for files and nodes.
    pub stem: String,
    /// Index of its material.
    pub material: usize,
    /// The file's mesh, or one that holds the placement's shear or mirror.
    pub mesh: Arc<Mesh>,
    /// Maps mesh coordinates to world coordinates: a rotation, a scale along the mesh's axes, a translation.
    pub to_world: Matrix,
}

/// The objects of `capture` that are there, those whose presence is at least a half.
///
/// # Errors
/// A mesh that was not read, a placement that flattens it.
pub fn parts(capture: &Capture, meshes: &BTreeMap<String, Arc<Mesh>>) -> Result<Vec<Part>> {
    let mut names = Names::default();
    let mut parts = Vec::new();
    for object in capture.objects.iter().filter(|object| object.presence >= 0.5) {
        let refuse = |problem: &str, mend: &str| {
            SceneError::new(CAPTURE_FILE, problem, mend).at(format!("object.{}", object.name))
        };
        let place = object.placement();
        if !place.iter().flatten().all(|entry| entry.is_finite()) || determinant(&place) == 0.0 {
            return Err(refuse("has a placement that flattens it", "mend object_to_world and scale").into());
        }
        let mesh = meshes.get(&object.mesh).ok_or_else(|| refuse("has a mesh that was not read", "report this"))?;
        let material = capture.materials.iter().position(|material| material.name == object.material);
        let material = material.ok_or_else(|| refuse("has no material", "name a [[material]] of this capture"))?;
        let (mesh, to_world) = if is_sheared(&place) { baked_into(mesh, &place) } else { (mesh.clone(), place) };
        parts.push(Part { stem: names.file(&object.name), material, mesh, to_world });
    }
    Ok(parts)
}

/// Judges the objects' numbers: they are the same in all formats.
pub fn judge(capture: &Capture, ledger: &mut Ledger) {
    for object in &capture.objects {
        let name = format!("object.{}", object.name);
        if is_sheared(&object.placement()) && object.presence >= 0.5 {
            let place = "shear and mirror in the mesh's vertices, the rest in the object's motion";
            ledger.exact(&name, place);
        } else {
            ledger.exact(&name, "the object's motion");
        }
        ledger.lost(&format!("{name}.materials"), "the whole part has one material");
        let name = format!("{name}.presence");
        if object.presence == 0.0 {
            ledger.exact(&name, "left out");
        } else if object.presence == 1.0 {
            ledger.exact(&name, "there");
        } else if object.presence >= 0.5 {
            ledger.approximated(&name, "there all the time");
        } else {
            ledger.approximated(&name, "left out");
        }
    }
}

fn determinant(m: &Matrix) -> f64 {
    let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
    matrix::cross(column(0), column(1)).iter().zip(column(2)).map(|(a, b)| a * b).sum()
}

/// Whether a placement mirrors, or has axes that are not at right angles: formats that say motion by rotation and scale
/// cannot hold it.
fn is_sheared(m: &Matrix) -> bool {
    let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let skew = |i: usize, j: usize| {
        dot(column(i), column(j)).abs() / (dot(column(i), column(i)) * dot(column(j), column(j))).sqrt()
    };
    determinant(m) < 0.0 || [skew(0, 1), skew(0, 2), skew(1, 2)].into_iter().any(|s| s > 1e-6)
}

/// `mesh` turned, stretched and mirrored as `place` says, and the translation that is left.
#[allow(clippy::cast_possible_truncation)] // Meshes are single precision.
fn baked_into(mesh: &Mesh, place: &Matrix) -> (Arc<Mesh>, Matrix) {
    let column = |j: usize| [place[0][j], place[1][j], place[2][j]];
    let mirrors = determinant(place) < 0.0;
    // Normals turn by the cofactors; their sign is the mirror's.
    let sign = if mirrors { -1.0 } else { 1.0 };
    let across =
        [matrix::cross(column(1), column(2)), matrix::cross(column(2), column(0)), matrix::cross(column(0), column(1))];
    let normal = |n: &[f32; 3]| {
        let n = n.map(f64::from);
        let turned = [0, 1, 2].map(|i| sign * (0..3).map(|k| across[k][i] * n[k]).sum::<f64>());
        matrix::unit(turned).map(|x| x as f32)
    };
    let baked = Mesh {
        positions: mesh.positions.iter().map(|p| direction(place, p.map(f64::from)).map(|x| x as f32)).collect(),
        normals: mesh.normals.as_ref().map(|normals| normals.iter().map(normal).collect()),
        triangles: mesh.triangles.iter().map(|&[a, b, c]| if mirrors { [a, c, b] } else { [a, b, c] }).collect(),
        degenerate: mesh.degenerate,
    };
    let mut shift = diagonal([1.0; 3]);
    (0..3).for_each(|i| shift[i][3] = place[i][3]);
    (Arc::new(baked), shift)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Mesh {
        Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: Some(vec![[0.0, 0.0, 1.0]; 3]),
            triangles: vec![[0, 1, 2]],
            degenerate: 0,
        }
    }

    #[test]
    fn a_mirror_goes_into_the_mesh_and_keeps_its_outside() {
        let mut place = diagonal([1.0, 1.0, -2.0]);
        place[2][3] = 5.0;
        assert!(is_sheared(&place));
        let (mesh, left) = baked_into(&triangle(), &place);
        // What looked up looks down, and its winding says so.
        assert_eq!(mesh.normals.as_ref().unwrap()[0], [0.0, 0.0, -1.0]);
        assert_eq!(mesh.triangles, [[0, 2, 1]]);
        assert_eq!((left[2][2], left[2][3]), (1.0, 5.0));
        assert!(!is_sheared(&diagonal([1.0, 3.0, 2.0])));
        let mut sheared = diagonal([1.0; 3]);
        sheared[0][1] = 0.1;
        assert!(is_sheared(&sheared));
    }
}
