//! STL: triangles without connection, binary and ascii.

use std::io::Cursor;

use super::Surface;
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

const MEND: &str = "export the mesh again, as a binary STL or PLY";

/// A binary STL: a free text of 80 bytes, a count, and 50 bytes per triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Reads an STL file, joining vertices of exactly the same position. Its normals belong to faces and follow from them,
/// so they are not kept.
pub(super) fn read(file: &str, bytes: &[u8]) -> Result<Surface> {
    let announced = bytes
        .get(HEADER - 4..HEADER)
        .and_then(|count| count.try_into().ok())
        .map_or(0, |count| u32::from_le_bytes(count) as usize);
    let mesh = if bytes.len() >= HEADER && bytes.len() - HEADER == announced * TRIANGLE {
        // The size decides, since many exporters begin the free text of a binary file with the ascii format's "solid".
        let mut blank = bytes.to_vec();
        blank.iter_mut().take(HEADER - 4).for_each(|byte| *byte = 0);
        stl_io::read_stl(&mut Cursor::new(blank))
    } else if bytes.starts_with(b"solid") {
        check_ascii(file, bytes)?;
        stl_io::read_stl(&mut Cursor::new(bytes))
    } else {
        let problem = format!("announces {announced} triangles, which is not what its {} bytes hold", bytes.len());
        return Err(SceneError::new(file, problem, "the file is truncated or no STL: export it again").at("header"));
    };
    let mesh = mesh.map_err(|error| SceneError::new(file, one_line(&error), MEND))?;
    let narrow = |index: usize| u32::try_from(index).unwrap_or(u32::MAX);
    Ok(Surface {
        positions: mesh.vertices.iter().map(|vertex| vertex.0).collect(),
        normals: None,
        triangles: mesh.faces.iter().map(|face| face.vertices.map(narrow)).collect(),
    })
}

/// The reader stops after the first solid, and so would lose the others without a word.
fn check_ascii(file: &str, bytes: &[u8]) -> Result<()> {
    let lines = bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii_start);
    match lines.filter(|line| line.starts_with(b"solid")).count() {
        1 => Ok(()),
        solids => {
            Err(SceneError::new(file, format!("has {solids} solids"), "join them into one, or export as binary STL"))
        }
    }
}
