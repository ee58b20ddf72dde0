//! OBJ: Wavefront text files.

use std::collections::BTreeSet;
use std::io::{BufRead, Read, Result as IoResult};
use std::path::Path;

use tobj::{LoadError, LoadOptions};

use super::Surface;
use super::number::{number, without_mark};
use super::polygon::Splitter;
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

const MEND: &str = "export the mesh again, as OBJ or PLY";

/// Reads an OBJ file's vertices, normals and faces; a vertex is split where its corners have different normals. Everything
/// else in the file (materials, groups, lines, points...) is passed over, and what would have shown is remarked.
pub(super) fn read(file: &str, bytes: &[u8]) -> Result<Surface> {
    let mut geometry = Geometry { rest: without_mark(bytes), ..Geometry::default() };
    let options = LoadOptions { triangulate: false, single_index: true, ..LoadOptions::default() };
    let no_materials = |_: &Path| Err(LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut geometry, &options, no_materials).map_err(|error| {
        let broken = SceneError::new(file, one_line(&error), MEND);
        match error {
            // Found when all lines are read: no line to name.
            LoadError::FaceVertexOutOfBounds | LoadError::FaceNormalOutOfBounds => broken.at("face"),
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
    let triangles = triangles(&positions, &mesh.indices, &mesh.face_arities)
        .map_err(|(face, problem)| SceneError::new(file, problem, MEND).at(format!("face {face}")))?;
    Ok(Surface { positions, normals, triangles, remarks: geometry.remarks() })
}

/// `arities` is empty where every face is a triangle. The error is a face, counted from 0, and what is wrong with it.
fn triangles(
    positions: &[[f64; 3]],
    indices: &[u32],
    arities: &[u32],
) -> std::result::Result<Vec<[u32; 3]>, (usize, String)> {
    if arities.is_empty() {
        return Ok(indices.as_chunks().0.to_vec());
    }
    let (mut splitter, mut triangles, mut rest) = (Splitter::new(), Vec::with_capacity(indices.len() / 2), indices);
    for (face, &arity) in arities.iter().enumerate() {
        let (corners, others) = rest.split_at_checked(arity as usize).unwrap_or((rest, &[]));
        splitter.split(positions, corners, &mut triangles).map_err(|problem| (face, problem))?;
        rest = others;
    }
    Ok(triangles)
}

/// The lines of an OBJ file that shape its surface, one buffer each.
///
/// The library would take a polyline (`l`) for a polygon, give up at a name that is not UTF-8, at a line that goes on in
/// the next one and at a number of an old C library, and split a mesh at every group; and it does not tell in which line
/// it found an error, which the number here does.
#[derive(Default)]
struct Geometry<'a> {
    rest: &'a [u8],
    statement: Vec<u8>,
    read: usize,
    number: usize,
    materials: BTreeSet<&'a [u8]>,
    parts: BTreeSet<&'a [u8]>,
    colours: bool,
    textures: bool,
}

impl<'a> Geometry<'a> {
    fn line(&mut self) -> &'a [u8] {
        let end = self.rest.iter().position(|&byte| byte == b'\n').map_or(self.rest.len(), |newline| newline + 1);
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest;
        self.number += 1;
        line.trim_ascii()
    }

    fn next_statement(&mut self) {
        self.statement.clear();
        self.read = 0;
        let line = self.line();
        let keyword = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        let named = line.get(keyword.len()..).unwrap_or_default().trim_ascii();
        match keyword {
            b"v" | b"vn" | b"f" => {}
            // A polyline's further lines belong to it, too.
            _ => {
                match keyword {
                    b"usemtl" => _ = self.materials.insert(named),
                    b"o" | b"g" => _ = self.parts.insert(named),
                    b"vt" => self.textures = true,
                    _ => {}
                }
                let mut last = line;
                while !keyword.starts_with(b"#") && last.ends_with(b"\\") && !self.rest.is_empty() {
                    last = self.line();
                }
                return;
            }
        }
        let mut last = line;
        while let Some(goes_on) = last.strip_suffix(b"\\") {
            self.statement.extend(goes_on);
            self.statement.push(b' ');
            last = self.line();
            if self.rest.is_empty() {
                break;
            }
        }
        self.statement.extend(last);
        if keyword != b"f" {
            self.plain_numbers();
            let values = self.statement.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count() - 1;
            self.colours |= keyword == b"v" && values >= 6;
        }
        self.statement.push(b'\n');
    }

    /// Writes the numbers that only [`number`] can read as the library reads them.
    fn plain_numbers(&mut self) {
        let foreign = |word: &&[u8]| std::str::from_utf8(word).is_ok_and(|text| text.parse::<f64>().is_err());
        let words = || self.statement.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        if !words().skip(1).any(|word| foreign(&word)) {
            return;
        }
        let plain = |word: &[u8]| match number(word) {
            Some(value) => format!("{value:?}").into_bytes(),
            None => word.to_vec(),
        };
        self.statement = words().map(plain).collect::<Vec<_>>().join(&b' ');
    }

    fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.parts.len() > 1 {
            remarks.push(format!("has {} groups or objects, which become one", self.parts.len()));
        }
        if self.materials.len() > 1 {
            remarks.push(format!("names {} materials, which are not used", self.materials.len()));
        }
        if self.colours {
            remarks.push("has vertex colours, which are not used".to_owned());
        }
        if self.textures {
            remarks.push("has texture coordinates, which are not used".to_owned());
        }
        remarks
    }
}

impl BufRead for Geometry<'_> {
    fn fill_buf(&mut self) -> IoResult<&[u8]> {
        while self.read >= self.statement.len() && !self.rest.is_empty() {
            self.next_statement();
        }
        Ok(self.statement.get(self.read..).unwrap_or_default())
    }

    fn consume(&mut self, amount: usize) {
        self.read = self.read.saturating_add(amount);
    }
}

impl Read for Geometry<'_> {
    fn read(&mut self, target: &mut [u8]) -> IoResult<usize> {
        let count = self.fill_buf()?.read(target)?;
        self.consume(count);
        Ok(count)
    }
}
