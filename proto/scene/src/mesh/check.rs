//! What every mesh must satisfy before a ray may meet it, whatever file it came from.

use glam::DVec3;

use super::look::retain;
use super::{Look, Mesh, Surface};
use crate::error::{Result, SceneError};

/// The range of a mesh's largest extent, in metres. Outside of it, a file is not in metres, or not a part.
const EXTENT: std::ops::RangeInclusive<f64> = 1e-9..=1e6;

/// A squared length may differ from one by this much and still count as one: f32 rounding alone gives up to 4e-7.
/// Normals within it stay as they are, so that writing and reading a mesh changes no bit.
const UNIT_TOLERANCE: f64 = 1e-6;

/// A triangle whose height is below this fraction of its longest edge has no area that f32 vertices could hold.
const SLIVER: f64 = 1e-8;

/// Rounding to 32 bits may move a vertex by this fraction of the mesh's extent: a tenth of a pixel where the part fills
/// 1000 pixels.
const ROUNDING: f64 = 1e-4;

/// 32-bit floats may lie apart by this fraction of the extent where the mesh is. A file of such floats has lost what lay
/// between them, which no comparison can show: steps of a pixel where the part fills 1000.
const SPACING: f64 = 1e-3;

/// Turns what a reader found into a mesh that can be rendered.
///
/// # Errors
/// See [`super::read`].
pub(super) fn finish(file: &str, surface: Surface) -> Result<(Mesh, Option<Look>)> {
    let Surface { positions: exact, mut normals, mut triangles, remarks: _, mut look } = surface;
    if triangles.is_empty() {
        return Err(SceneError::new(
            file,
            "has no faces",
            "export a mesh that has a surface, not a point cloud or lines",
        ));
    }
    if exact.is_empty() {
        return Err(SceneError::new(file, "has no vertices", "export a mesh that has a surface"));
    }
    if u32::try_from(exact.len()).is_err() {
        let problem = format!("has {} vertices, more than 32-bit indices reach", exact.len());
        return Err(SceneError::new(file, problem, "decimate the mesh"));
    }
    if let Some(normals) = &normals
        && normals.len() != exact.len()
    {
        return Err(SceneError::new(
            file,
            format!("has {} normals for {} vertices", normals.len(), exact.len()),
            "export a normal for every vertex, or none",
        ));
    }
    check_indices(file, &triangles, exact.len())?;
    #[allow(clippy::cast_possible_truncation)]
    let mut positions: Vec<[f32; 3]> = exact.iter().map(|position| position.map(|value| value as f32)).collect();
    check_positions(file, &positions, &used(&triangles, exact.len()))?;
    check_extent(file, &exact, &triangles)?;
    check_rounding(file, &exact, &positions, &triangles)?;
    let before = triangles.len();
    let sized: Vec<bool> = triangles.iter().map(|triangle| has_area(&positions, triangle)).collect();
    retain(&mut triangles, &sized);
    if triangles.is_empty() {
        return Err(SceneError::new(
            file,
            format!("has {before} triangles and none has an area"),
            "export the mesh with more precision, or a mesh that has a surface",
        ));
    }
    let degenerate = before - triangles.len();
    let used = used(&triangles, positions.len());
    if let Some(normals) = &mut normals {
        check_normals(file, normals, &used)?;
    }
    let kept = leave_out(&mut positions, &mut normals, &mut triangles, &used);
    if let Some(look) = &mut look {
        look.keep(&sized, &kept);
    }
    Ok((Mesh { degenerate, positions, normals, triangles }, look))
}

/// Which vertices a triangle uses.
fn used(triangles: &[[u32; 3]], vertices: usize) -> Vec<bool> {
    let mut used = vec![false; vertices];
    for &index in triangles.as_flattened() {
        if let Some(slot) = used.get_mut(index as usize) {
            *slot = true;
        }
    }
    used
}

/// Leaves out the vertices that no triangle uses and that are unsound, so that all of a [`Mesh`] is sound. Which ones stay.
fn leave_out(
    positions: &mut Vec<[f32; 3]>,
    normals: &mut Option<Vec<[f32; 3]>>,
    triangles: &mut [[u32; 3]],
    used: &[bool],
) -> Vec<bool> {
    let sound = |values: &[f32; 3]| values.iter().all(|value| value.is_finite());
    let keep: Vec<bool> = (used.iter().zip(positions.iter()).enumerate())
        .map(|(vertex, (used, position))| {
            let normal = normals.as_ref().and_then(|normals| normals.get(vertex));
            *used || (sound(position) && normal.is_none_or(|normal| sound(normal) && *normal != [0.0; 3]))
        })
        .collect();
    if keep.iter().all(|kept| *kept) {
        return keep;
    }
    let mut next = 0;
    let renumbered: Vec<u32> = keep
        .iter()
        .map(|kept| {
            next += u32::from(*kept);
            next.saturating_sub(1)
        })
        .collect();
    for index in triangles.as_flattened_mut() {
        *index = renumbered.get(*index as usize).copied().unwrap_or(*index);
    }
    for list in [Some(positions), normals.as_mut()].into_iter().flatten() {
        retain(list, &keep);
    }
    keep
}

fn check_positions(file: &str, positions: &[[f32; 3]], used: &[bool]) -> Result<()> {
    let mut pairs = positions.iter().zip(used).enumerate();
    match pairs.find(|(_, (position, used))| **used && !position.iter().all(|value| value.is_finite())) {
        None => Ok(()),
        Some((vertex, (position, _))) => Err(SceneError::new(
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

/// Gives the normals unit length. Those that no triangle uses stay as they are where they have none.
fn check_normals(file: &str, normals: &mut [[f32; 3]], used: &[bool]) -> Result<()> {
    for (vertex, (normal, used)) in normals.iter_mut().zip(used).enumerate() {
        let direction = DVec3::from_array(normal.map(f64::from));
        let squared = direction.length_squared();
        // Squares of f32 values neither overflow nor vanish in f64, so zero and infinity are the file's own.
        if !squared.is_finite() || squared == 0.0 {
            if !*used {
                continue;
            }
            return Err(SceneError::new(
                file,
                format!("has the normal {normal:?}, which is no direction"),
                "recompute the normals, or export without normals to use face normals",
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

/// The box around the vertices that triangles use.
fn bounds(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> (DVec3, DVec3) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for position in triangles.as_flattened().iter().filter_map(|&index| positions.get(index as usize)) {
        low = low.min(DVec3::from_array(*position));
        high = high.max(DVec3::from_array(*position));
    }
    (low, high)
}

fn check_extent(file: &str, positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<()> {
    let (low, high) = bounds(positions, triangles);
    let extent = (high - low).max_element();
    // A single point is a mesh without an area, which is said later.
    if EXTENT.contains(&extent) || extent == 0.0 {
        return Ok(());
    }
    Err(SceneError::new(
        file,
        format!("is {extent:e} m large, outside of {:e}..={:e} m", EXTENT.start(), EXTENT.end()),
        "export it in metres (meshes in millimetres or microns are a thousand or a million times too large)",
    )
    .at("bounding box"))
}

fn check_rounding(file: &str, exact: &[[f64; 3]], rounded: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<()> {
    let (low, high) = bounds(exact, triangles);
    let extent = (high - low).max_element();
    let far = low.abs().max(high.abs()).max_element();
    #[allow(clippy::cast_possible_truncation)]
    let spacing = f64::from((far as f32).next_up()) - f64::from(far as f32);
    let moved = |&index: &u32| {
        let (exact, rounded) = exact.get(index as usize).zip(rounded.get(index as usize))?;
        Some(exact.iter().zip(rounded).map(|(exact, rounded)| (exact - f64::from(*rounded)).abs()).fold(0.0, f64::max))
    };
    let moved = triangles.as_flattened().iter().filter_map(moved).fold(0.0, f64::max);
    if moved <= ROUNDING * extent && (spacing <= SPACING * extent || extent == 0.0) {
        return Ok(());
    }
    Err(SceneError::new(
        file,
        format!(
            "lies up to {far} m from its origin, where 32-bit floats are {spacing:.1e} m apart, which is coarse for \
             {extent:.3} m of mesh"
        ),
        "subtract an offset from its coordinates before the export, and put the offset into object_to_world",
    )
    .at("bounding box"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finish(file: &str, surface: Surface) -> Result<Mesh> {
        super::finish(file, surface).map(|(mesh, _)| mesh)
    }

    fn triangle(positions: [[f32; 3]; 3]) -> Surface {
        let positions = positions.map(|position| position.map(f64::from)).to_vec();
        Surface { positions, triangles: vec![[0, 1, 2]], ..Surface::default() }
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
            positions: once.positions.iter().map(|position| position.map(f64::from)).collect(),
            remarks: Vec::new(),
            look: None,
            normals: once.normals.clone(),
            triangles: once.triangles.clone(),
        };
        assert_eq!(finish("part.ply", again).unwrap(), once);
    }

    #[test]
    fn what_no_triangle_uses_may_be_unsound_and_is_left_out() {
        let mut surface = triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        // A vertex without a normal, one that is nowhere, and a sound one.
        surface.positions.splice(1..1, [[0.5, 0.5, 9.0], [f64::NAN, 0.0, 0.0], [0.25, 0.0, 0.0]]);
        surface.normals = Some([[0.0, 0.0, 1.0]; 6].to_vec());
        surface.normals.as_mut().unwrap()[1] = [0.0; 3];
        surface.triangles = vec![[0, 4, 5]];
        let mesh = finish("part.ply", surface).unwrap();
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [0.25, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!((mesh.normals.unwrap().len(), mesh.triangles), (4, vec![[0, 2, 3]]));
    }

    #[test]
    fn a_place_where_floats_are_coarse_is_refused_and_one_where_they_are_fine_is_not() {
        let at = |offset: f64| {
            let mut surface = triangle([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.3, 0.0]]);
            surface.positions.iter_mut().for_each(|position| position[1] += offset);
            finish("part.ply", surface)
        };
        // 4 649 776 m north: UTM coordinates of Europe. Floats are half a metre apart there.
        let error = at(4_649_776.1).unwrap_err();
        assert!(error.problem.contains("5.0e-1 m apart"), "{error}");
        assert!(at(-1e4).is_err());
        // Half of 1.5e-5 m at most, of 0.3 m.
        assert!(at(200.1).is_ok());
    }
}
