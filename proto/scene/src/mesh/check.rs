//! What every mesh must satisfy before a ray may meet it, whatever file it came from.

use glam::DVec3;

use super::{Mesh, Surface};
use crate::error::{Result, SceneError};

/// The range of a mesh's largest extent, in metres. Outside of it, a file is not in metres, or not a part.
const EXTENT: std::ops::RangeInclusive<f64> = 1e-9..=1e6;

/// A squared length may differ from one by this much and still count as one: f32 rounding alone gives up to 4e-7.
/// Normals within it stay as they are, so that writing and reading a mesh changes no bit.
const UNIT_TOLERANCE: f64 = 1e-6;

/// A triangle whose height is below this fraction of its longest edge has no area that f32 vertices could hold.
const SLIVER: f64 = 1e-8;

/// Turns what a reader found into a mesh that can be rendered.
///
/// # Errors
/// See [`super::read`].
pub(super) fn finish(file: &str, surface: Surface) -> Result<Mesh> {
    let Surface { positions, mut normals, mut triangles } = surface;
    if triangles.is_empty() {
        return Err(SceneError::new(
            file,
            "has no faces",
            "export a mesh that has a surface, not a point cloud or lines",
        ));
    }
    if positions.is_empty() {
        return Err(SceneError::new(file, "has no vertices", "export a mesh that has a surface"));
    }
    if u32::try_from(positions.len()).is_err() {
        let problem = format!("has {} vertices, more than 32-bit indices reach", positions.len());
        return Err(SceneError::new(file, problem, "decimate the mesh"));
    }
    check_positions(file, &positions)?;
    check_indices(file, &triangles, positions.len())?;
    if let Some(normals) = &mut normals {
        check_normals(file, normals, positions.len())?;
    }
    let before = triangles.len();
    triangles.retain(|triangle| has_area(&positions, triangle));
    if triangles.is_empty() {
        return Err(SceneError::new(
            file,
            format!("has {before} triangles and none has an area"),
            "export the mesh with more precision, or a mesh that has a surface",
        ));
    }
    check_extent(file, &positions, &triangles)?;
    Ok(Mesh { degenerate: before - triangles.len(), positions, normals, triangles })
}

fn check_positions(file: &str, positions: &[[f32; 3]]) -> Result<()> {
    match positions.iter().enumerate().find(|(_, position)| !position.iter().all(|value| value.is_finite())) {
        None => Ok(()),
        Some((vertex, position)) => Err(SceneError::new(
            file,
            format!("has the position {position:?}, which is not finite"),
            "remove the vertex, or export coordinates that fit 32-bit floats",
        )
        .at(format!("vertex {vertex}"))),
    }
}

fn check_indices(file: &str, triangles: &[[u32; 3]], vertices: usize) -> Result<()> {
    match triangles.iter().enumerate().find(|(_, triangle)| triangle.iter().any(|&index| index as usize >= vertices)) {
        None => Ok(()),
        Some((face, triangle)) => Err(SceneError::new(
            file,
            format!("joins the vertices {triangle:?}, but there are only {vertices} (counted from 0)"),
            "export the mesh again: its faces and vertices do not belong together",
        )
        .at(format!("triangle {face}"))),
    }
}

fn check_normals(file: &str, normals: &mut [[f32; 3]], vertices: usize) -> Result<()> {
    if normals.len() != vertices {
        return Err(SceneError::new(
            file,
            format!("has {} normals for {vertices} vertices", normals.len()),
            "export a normal for every vertex, or none",
        ));
    }
    for (vertex, normal) in normals.iter_mut().enumerate() {
        let direction = DVec3::from_array(normal.map(f64::from));
        let squared = direction.length_squared();
        // Squares of f32 values neither overflow nor vanish in f64, so zero and infinity are the file's own.
        if !squared.is_finite() || squared == 0.0 {
            return Err(SceneError::new(
                file,
                format!("has the normal {normal:?}, which is no direction"),
                "recompute the normals, remove vertices that no face uses, or export without normals to use face normals",
            )
            .at(format!("vertex {vertex}")));
        }
        if (squared - 1.0).abs() > UNIT_TOLERANCE {
            *normal = (direction / squared.sqrt()).as_vec3().to_array();
        }
    }
    Ok(())
}

fn corner(positions: &[[f32; 3]], index: u32) -> DVec3 {
    positions.get(index as usize).map_or(DVec3::NAN, |position| DVec3::from_array(position.map(f64::from)))
}

fn has_area(positions: &[[f32; 3]], triangle: &[u32; 3]) -> bool {
    let [a, b, c] = triangle.map(|index| corner(positions, index));
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    (b - a).cross(c - a).length() > SLIVER * longest
}

fn check_extent(file: &str, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<()> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for point in triangles.iter().flatten().map(|&index| corner(positions, index)) {
        low = low.min(point);
        high = high.max(point);
    }
    let extent = (high - low).max_element();
    if EXTENT.contains(&extent) {
        return Ok(());
    }
    Err(SceneError::new(
        file,
        format!("is {extent:e} m large, outside of {:e}..={:e} m", EXTENT.start(), EXTENT.end()),
        "export it in metres (meshes in millimetres or microns are a thousand or a million times too large)",
    )
    .at("bounding box"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(positions: [[f32; 3]; 3]) -> Surface {
        Surface { positions: positions.to_vec(), normals: None, triangles: vec![[0, 1, 2]] }
    }

    #[test]
    fn keeps_a_part_of_any_plausible_size_and_place() {
        for (scale, offset) in [(1e-6, 0.0), (1e-3, 10.0), (1.0, 0.0), (1e5, -1e5)] {
            let surface = triangle(
                [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|p| p.map(|x: f32| x * scale + offset)),
            );
            assert_eq!(finish("part.ply", surface).unwrap().triangles.len(), 1, "scale {scale} offset {offset}");
        }
    }

    #[test]
    fn counts_triangles_without_area_and_leaves_them_out() {
        let mut surface = triangle([[0.1, 0.1, 0.1], [0.2, 0.2, 0.2], [0.0, 1.0, 0.0]]);
        surface.positions.push([0.4, 0.4, 0.4]);
        surface.triangles.extend([[0, 0, 2], [0, 1, 3]]);
        let mesh = finish("part.ply", surface).unwrap();
        assert_eq!((mesh.triangles, mesh.degenerate), (vec![[0, 1, 2]], 2));
    }

    #[test]
    fn normalises_once_and_then_leaves_every_bit() {
        let mut surface = triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        surface.normals = Some(vec![[0.3, -0.4, 1.2], [1e-20, 2e-20, 3e-20], [3e30, 1e30, 0.0]]);
        let once = finish("part.ply", surface).unwrap();
        for normal in once.normals.as_ref().unwrap() {
            let squared: f64 = normal.iter().map(|&value| f64::from(value) * f64::from(value)).sum();
            assert!((squared - 1.0).abs() < 4e-7, "{normal:?}");
        }
        let again = Surface {
            positions: once.positions.clone(),
            normals: once.normals.clone(),
            triangles: once.triangles.clone(),
        };
        assert_eq!(finish("part.ply", again).unwrap(), once);
    }
}
