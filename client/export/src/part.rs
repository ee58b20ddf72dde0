//! Objects: meshes in coordinates from which a motion leads to the world.

use crate::Result;
use crate::ledger::Ledger;
use crate::matrix::{self, Matrix, diagonal, direction};
use crate::name::Names;
use crate::paint::Paint;
use gonio_scene::capture::{CAPTURE_FILE, Object};
use gonio_scene::mesh::{Look, Mesh};
use gonio_scene::textures::wants_look;
use gonio_scene::{Assets, Capture, SceneError};
use std::sync::Arc;

/// What an object that is there has of one material.
pub struct Part {
    /// A name for files and nodes.
    pub stem: String,
    /// Index of its material.
    pub material: usize,
    /// How its material varies.
    pub paint: Paint,
    /// Texture coordinates of each vertex, where a texture varies its material: u to the right, v down.
    pub coordinates: Option<Vec<[f32; 2]>>,
    /// The file's triangles, or some that hold the placement's shear or mirror.
    pub mesh: Arc<Mesh>,
    /// Maps mesh coordinates to world coordinates: a rotation, a scale along the mesh's axes, a translation.
    pub to_world: Matrix,
}

/// The objects of `capture` that are there, those whose presence is at least a half; each material of an object is a part.
///
/// # Errors
/// A mesh that was not read, a placement that flattens it, a map that its mesh cannot serve.
pub fn parts(capture: &Capture, assets: &Assets) -> Result<Vec<Part>> {
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
        let mesh =
            assets.meshes.get(&object.mesh).ok_or_else(|| refuse("has a mesh that was not read", "report this"))?;
        for piece in pieces(capture, assets, object, mesh)? {
            let (mesh, to_world) =
                if is_sheared(&place) { baked_into(&piece.mesh, &place) } else { (piece.mesh, place) };
            let name =
                if piece.name.is_empty() { object.name.clone() } else { format!("{}-{}", object.name, piece.name) };
            let (stem, paint, coordinates) = (names.file(&name), piece.paint, piece.coordinates);
            parts.push(Part { stem, material: piece.material, paint, coordinates, mesh, to_world });
        }
    }
    Ok(parts)
}

/// The triangles of an object that have one material.
struct Piece {
    /// Of the mesh file's own material, where it has several.
    name: String,
    material: usize,
    paint: Paint,
    coordinates: Option<Vec<[f32; 2]>>,
    mesh: Arc<Mesh>,
}

fn pieces(capture: &Capture, assets: &Assets, object: &Object, mesh: &Arc<Mesh>) -> Result<Vec<Piece>> {
    let groups = assets.parts(capture, object)?;
    let look = assets.looks.get(&object.mesh).filter(|_| wants_look(capture, object));
    let piece = |(index, group): (usize, gonio_scene::textures::Part)| {
        let Some(look) = look else {
            let paint = Paint::default();
            return Some(Piece {
                name: String::new(),
                material: group.material,
                paint,
                coordinates: None,
                mesh: mesh.clone(),
            });
        };
        let (mesh, vertices) = only(mesh, |triangle| look.group_of(triangle) == index)?;
        let colours: Option<Vec<[f32; 3]>> = look.colours.as_deref().map(|all| picked(all, &vertices));
        let paint = Paint::new(&group.maps, colours.as_deref(), &assets.textures);
        let coordinates = look.coordinates.as_deref().filter(|_| paint.textured()).map(|all| picked(all, &vertices));
        let name = if look.groups.len() > 1 { group_name(look, index) } else { String::new() };
        Some(Piece { name, material: group.material, paint, coordinates, mesh })
    };
    Ok(groups.into_iter().enumerate().filter_map(piece).collect())
}

fn group_name(look: &Look, index: usize) -> String {
    let name = &look.groups[index].name;
    if name.is_empty() { index.to_string() } else { name.clone() }
}

fn picked<T: Copy>(all: &[T], vertices: &[usize]) -> Vec<T> {
    vertices.iter().map(|vertex| all[*vertex]).collect()
}

/// The triangles that `keep` names and the vertices that they use, by their numbers before; `None` where there are none.
#[allow(clippy::cast_possible_truncation)] // A mesh has fewer than 2^32 vertices.
fn only(mesh: &Arc<Mesh>, keep: impl Fn(usize) -> bool) -> Option<(Arc<Mesh>, Vec<usize>)> {
    let triangles: Vec<[u32; 3]> =
        (0..mesh.triangles.len()).filter(|index| keep(*index)).map(|index| mesh.triangles[index]).collect();
    if triangles.is_empty() {
        return None;
    }
    let mut number = vec![u32::MAX; mesh.positions.len()];
    let mut vertices = Vec::new();
    for vertex in triangles.iter().flatten().map(|vertex| *vertex as usize) {
        if number[vertex] == u32::MAX {
            number[vertex] = vertices.len() as u32;
            vertices.push(vertex);
        }
    }
    let kept = Mesh {
        positions: picked(&mesh.positions, &vertices),
        normals: mesh.normals.as_deref().map(|normals| picked(normals, &vertices)),
        triangles: triangles.iter().map(|triangle| triangle.map(|vertex| number[vertex as usize])).collect(),
        degenerate: 0,
    };
    Some((Arc::new(kept), vertices))
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
        ledger.exact(&format!("{name}.materials"), "each material's triangles are a shape of their own");
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
    fn a_piece_has_its_triangles_and_the_vertices_that_they_use() {
        let mut two = triangle();
        two.positions.push([1.0, 1.0, 0.0]);
        two.normals = None;
        two.triangles.push([1, 3, 2]);
        let (piece, vertices) = only(&Arc::new(two.clone()), |index| index == 1).unwrap();
        assert_eq!((vertices.as_slice(), piece.triangles.as_slice()), ([1, 3, 2].as_slice(), [[0, 1, 2]].as_slice()));
        assert_eq!(piece.positions[1], [1.0, 1.0, 0.0]);
        assert!(only(&Arc::new(two), |_| false).is_none());
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
