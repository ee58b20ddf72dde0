//! OBJ: Wavefront text files.

mod lines;
mod look;

use std::path::Path;

use tobj::{LoadError, LoadOptions};

use super::Surface;
use super::number::without_mark;
use super::polygon::Splitter;
use crate::decoder::one_line;
use crate::error::{Result, SceneError};
use crate::files::Files;
use lines::Geometry;

const MEND: &str = "export the mesh again, as OBJ or PLY";

/// Reads an OBJ file's vertices, normals and faces; a vertex is split where its corners have different normals, and for
/// its `look` where they have different texture coordinates. Everything else in the file (groups, lines, points...) is
/// passed over, and what would have shown is remarked.
pub(super) fn read(files: &dyn Files, file: &str, bytes: &[u8], look: bool) -> Result<Surface> {
    let mut geometry = Geometry::new(without_mark(bytes), look);
    let options = LoadOptions { triangulate: false, single_index: true, ..LoadOptions::default() };
    let no_materials = |_: &Path| Err(LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut geometry, &options, no_materials).map_err(|error| {
        let broken = SceneError::new(file, one_line(&error), MEND);
        match error {
            // Found when all lines are read: no line to name.
            LoadError::FaceVertexOutOfBounds
            | LoadError::FaceNormalOutOfBounds
            | LoadError::FaceTexCoordOutOfBounds => broken.at("face"),
            _ => broken.at(format!("line {}", geometry.number)),
        }
    })?;

    // Without groups and materials there is one model, or none.
    let mesh = models.into_iter().next().map(|model| model.mesh).unwrap_or_default();
    let positions = mesh.positions.as_chunks().0.to_vec();
    #[allow(clippy::cast_possible_truncation)]
    let narrow = |normal: &[f64; 3]| normal.map(|value| value as f32);
    let normals: Vec<_> = mesh.normals.as_chunks().0.iter().map(narrow).collect();
    if !normals.is_empty() && normals.len() != positions.len() {
        return Err(SceneError::new(
            file,
            "has faces with normals and faces without",
            "export normals for every face, or for none to use face normals",
        )
        .at("vn"));
    }
    let normals = (!normals.is_empty()).then_some(normals);
    let (triangles, face_of) = triangles(&positions, &mesh.indices, &mesh.face_arities)
        .map_err(|(face, problem)| SceneError::new(file, problem, MEND).at(format!("face {face}")))?;
    let look = look.then(|| look::of(files, file, &geometry, &mesh, &face_of)).transpose()?;
    Ok(Surface { positions, normals, triangles, remarks: geometry.remarks(), look })
}

/// The triangles, and the face that each is a part of. `arities` is empty where every face is a triangle. The error is a
/// face, counted from 0, and what is wrong with it.
#[allow(clippy::type_complexity)]
fn triangles(
    positions: &[[f64; 3]],
    indices: &[u32],
    arities: &[u32],
) -> std::result::Result<(Vec<[u32; 3]>, Vec<usize>), (usize, String)> {
    if arities.is_empty() {
        let triangles = indices.as_chunks().0.to_vec();
        let face_of = (0..triangles.len()).collect();
        return Ok((triangles, face_of));
    }
    let (mut splitter, mut triangles, mut rest) = (Splitter::new(), Vec::with_capacity(indices.len() / 2), indices);
    let mut face_of = Vec::with_capacity(indices.len() / 2);
    for (face, &arity) in arities.iter().enumerate() {
        let (corners, others) = rest.split_at_checked(arity as usize).unwrap_or((rest, &[]));
        splitter.split(positions, corners, &mut triangles).map_err(|problem| (face, problem))?;
        face_of.resize(triangles.len(), face);
        rest = others;
    }
    Ok((triangles, face_of))
}
