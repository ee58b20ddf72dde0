//! STL: triangles without connection, binary and ascii.

use std::collections::HashMap;
use std::io::Cursor;

use super::Surface;
use super::number::{number, without_mark};
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
    // The size decides, since many exporters begin the free text of a binary file with the ascii format's "solid".
    if bytes.len() >= HEADER && Some(bytes.len() - HEADER) == announced.checked_mul(TRIANGLE) {
        return binary(file, bytes);
    }
    let text = without_mark(bytes).trim_ascii_start();
    if text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
        return ascii(file, bytes);
    }
    let problem = format!("announces {announced} triangles, which is not what its {} bytes hold", bytes.len());
    Err(SceneError::new(file, problem, "the file is truncated or no STL: export it again").at("header"))
}

fn binary(file: &str, bytes: &[u8]) -> Result<Surface> {
    let mut blank = bytes.to_vec();
    blank.iter_mut().take(HEADER - 4).for_each(|byte| *byte = 0);
    let mesh =
        stl_io::read_stl(&mut Cursor::new(blank)).map_err(|error| SceneError::new(file, one_line(&error), MEND))?;
    let narrow = |index: usize| u32::try_from(index).unwrap_or(u32::MAX);
    // The two bytes behind a triangle are a colour in the dialects of VisCAM, SolidView and Magics.
    let (facets, _) = bytes.get(HEADER..).unwrap_or_default().as_chunks::<TRIANGLE>();
    let coloured = facets.windows(2).any(|pair| pair.first().map(|f| &f[48..]) != pair.last().map(|f| &f[48..]));
    Ok(Surface {
        look: None,
        positions: mesh.vertices.iter().map(|vertex| vertex.0.map(f64::from)).collect(),
        normals: None,
        triangles: mesh.faces.iter().map(|face| face.vertices.map(narrow)).collect(),
        remarks: if coloured { vec!["has colours, which are not used".to_owned()] } else { Vec::new() },
    })
}

/// Text in capitals or none. Several solids become one surface.
fn ascii(file: &str, bytes: &[u8]) -> Result<Surface> {
    let mut surface = Surface::default();
    let mut known: HashMap<[u64; 3], u32> = HashMap::new();
    let mut corners: Vec<u32> = Vec::with_capacity(3);
    let (mut solids, mut open) = (0, false);
    for (line, text) in without_mark(bytes).split(|&byte| byte == b'\n').enumerate() {
        let broken = |problem: &str| SceneError::new(file, problem, MEND).at(format!("line {}", line + 1));
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let Some(keyword) = words.next().map(<[u8]>::to_ascii_lowercase) else { continue };
        match keyword.as_slice() {
            b"solid" => {
                solids += 1;
                open = true;
            }
            b"endsolid" => open = false,
            b"vertex" => {
                let values: Option<Vec<f64>> = words.map(number).collect();
                let position: [f64; 3] = values
                    .and_then(|values| values.try_into().ok())
                    .ok_or_else(|| broken("has a vertex that is not three numbers"))?;
                // A negative zero is the same place.
                let next = u32::try_from(surface.positions.len()).unwrap_or(u32::MAX);
                let index = *known.entry(position.map(|value| (value + 0.0).to_bits())).or_insert(next);
                if index == next {
                    surface.positions.push(position);
                }
                corners.push(index);
            }
            b"facet" => corners.clear(),
            b"endfacet" => match *corners.as_slice() {
                [a, b, c] => surface.triangles.push([a, b, c]),
                _ => return Err(broken(&format!("ends a facet of {} corners", corners.len()))),
            },
            b"outer" | b"endloop" => {}
            _ => return Err(broken("begins with a word that an STL file does not have")),
        }
    }
    if open {
        return Err(SceneError::new(file, "has no endsolid", "the file is truncated: export it again"));
    }
    if solids > 1 {
        surface.remarks.push(format!("has {solids} solids, which become one"));
    }
    Ok(surface)
}
