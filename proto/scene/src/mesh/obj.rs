//! OBJ: Wavefront text files.

use std::io::{BufRead, Read, Result as IoResult};
use std::path::Path;

use tobj::{LoadError, LoadOptions};

use super::Surface;
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

/// Reads an OBJ file's vertices, normals and faces; polygons become fans around their first corner, and a vertex is
/// split where its corners have different normals. Everything else in the file (materials, groups, lines, points...) is
/// passed over.
pub(super) fn read(file: &str, bytes: &[u8]) -> Result<Surface> {
    let mut geometry = Geometry { rest: bytes, line: &[], number: 0 };
    let options = LoadOptions { triangulate: true, single_index: true, ..LoadOptions::default() };
    let no_materials = |_: &Path| Err(LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut geometry, &options, no_materials).map_err(|error| {
        let broken = SceneError::new(file, one_line(&error), "export the mesh again, as OBJ or PLY");
        match error {
            // Found when all lines are read: no line to name.
            LoadError::FaceVertexOutOfBounds | LoadError::FaceNormalOutOfBounds => broken.at("face"),
            _ => broken.at(format!("line {}", geometry.number)),
        }
    })?;

    // Without groups and materials there is one model, or none.
    let mesh = models.into_iter().next().map(|model| model.mesh).unwrap_or_default();
    let positions = mesh.positions.as_chunks().0.to_vec();
    let normals = mesh.normals.as_chunks().0.to_vec();
    if !normals.is_empty() && normals.len() != positions.len() {
        return Err(SceneError::new(
            file,
            "has faces with normals and faces without",
            "export normals for every face, or for none to use face normals",
        )
        .at("vn"));
    }
    let normals = (!normals.is_empty()).then_some(normals);
    Ok(Surface { positions, normals, triangles: mesh.indices.as_chunks().0.to_vec() })
}

/// The lines of an OBJ file that shape its surface, one buffer each.
///
/// The library would take a polyline (`l`) for a polygon, give up at a name that is not UTF-8, and split a mesh at every
/// group; and it does not tell in which line it found an error, which the number here does.
struct Geometry<'a> {
    rest: &'a [u8],
    line: &'a [u8],
    number: usize,
}

impl BufRead for Geometry<'_> {
    fn fill_buf(&mut self) -> IoResult<&[u8]> {
        while self.line.is_empty() && !self.rest.is_empty() {
            let end = self.rest.iter().position(|&byte| byte == b'\n').map_or(self.rest.len(), |newline| newline + 1);
            let (line, rest) = self.rest.split_at(end);
            self.rest = rest;
            self.number += 1;
            let statement = line.trim_ascii_start();
            let keyword = statement.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            if matches!(keyword, b"v" | b"vn" | b"f") {
                self.line = statement;
            }
        }
        Ok(self.line)
    }

    fn consume(&mut self, amount: usize) {
        self.line = self.line.get(amount..).unwrap_or_default();
    }
}

impl Read for Geometry<'_> {
    fn read(&mut self, target: &mut [u8]) -> IoResult<usize> {
        let count = self.fill_buf()?.read(target)?;
        self.consume(count);
        Ok(count)
    }
}
