//! PLY: Stanford polygon files, ascii and binary.

mod ascii;
mod look;
mod vertex;
mod write;

pub use write::write_ply;

use ascii::Lines;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyAccess, PropertyType, ScalarType};
use vertex::{CORNERS, Face, Vertex, WEDGES};

use super::Surface;
use super::number::without_mark;
use super::polygon::Splitter;
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

const MEND: &str = "export the mesh again, as a binary PLY";

/// An element of no concern (edges, materials...), read to get past it.
struct Passed;

impl PropertyAccess for Passed {
    fn new() -> Self {
        Self
    }
}

/// Reads a PLY file's `vertex` and `face` elements.
pub(super) fn read(file: &str, bytes: &[u8], look: bool) -> Result<Surface> {
    let bytes = without_mark(bytes);
    let mut reader = Reader::new(bytes);
    let header = Parser::<Passed>::new()
        .read_header(&mut reader)
        .map_err(|error| SceneError::new(file, one_line(&error), MEND).at("header"))?;
    let payload: &[u8] = reader.get_ref();
    check_header(file, &header, payload.len())?;

    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    let left = if header.encoding == Encoding::Ascii {
        let lines = bytes.len().checked_sub(payload.len()).and_then(|end| bytes.get(..end)).unwrap_or_default();
        let mut lines = Lines::new(payload, lines.iter().filter(|&&byte| byte == b'\n').count());
        for element in header.elements.values() {
            text_element(&mut lines, element, &mut vertices, &mut faces)
                .map_err(|problem| SceneError::new(file, problem, MEND).at(format!("element {}", element.name)))?;
        }
        lines.rest().len() - lines.rest().iter().take_while(|byte| byte.is_ascii_whitespace()).count()
    } else {
        for element in header.elements.values() {
            binary_element(&mut reader, element, &header, &mut vertices, &mut faces).map_err(|error| {
                SceneError::new(file, one_line(&error), MEND).at(format!("element {}", element.name))
            })?;
        }
        if reader.get_ref().iter().all(u8::is_ascii_whitespace) { 0 } else { reader.get_ref().len() }
    };
    if left > 0 {
        let problem = format!("has {left} bytes more than its header announces");
        return Err(SceneError::new(file, problem, MEND).at("header"));
    }
    surface(file, &header, &vertices, &faces, look)
}

fn text_element(
    lines: &mut Lines<'_>,
    element: &ElementDef,
    vertices: &mut Vec<Vertex>,
    faces: &mut Vec<Face>,
) -> std::result::Result<(), String> {
    let names: Vec<&str> = element.properties.keys().map(String::as_str).collect();
    let is_any = |of: &'static [&str]| names.iter().map(|name| of.contains(name)).collect::<Vec<bool>>();
    let (is_corners, is_wedges) = (is_any(&CORNERS), is_any(&WEDGES));
    for _ in 0..element.count {
        match element.name.as_str() {
            "vertex" => {
                let mut vertex = Vertex::default();
                lines.element(element, |property, value| {
                    if let Some(slot) = names.get(property).and_then(|name| vertex.slot(name)) {
                        *slot = value;
                    }
                })?;
                vertices.push(vertex);
            }
            "face" => {
                let mut face = Face { corners: Vec::with_capacity(3), wedges: Vec::new() };
                lines.element(element, |property, value| {
                    if is_corners.get(property) == Some(&true) {
                        face.corners.push(value);
                    } else if is_wedges.get(property) == Some(&true) {
                        face.wedges.push(value);
                    }
                })?;
                faces.push(face);
            }
            _ => lines.element(element, |_, _| ())?,
        }
    }
    Ok(())
}

fn binary_element(
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    header: &Header,
    vertices: &mut Vec<Vertex>,
    faces: &mut Vec<Face>,
) -> std::result::Result<(), ParseError> {
    match element.name.as_str() {
        "vertex" => *vertices = Parser::new().read_payload_for_element(reader, element, header)?,
        "face" => *faces = Parser::new().read_payload_for_element(reader, element, header)?,
        _ => _ = Parser::<Passed>::new().read_payload_for_element(reader, element, header)?,
    }
    Ok(())
}

#[allow(clippy::cast_possible_truncation)]
fn surface(file: &str, header: &Header, vertices: &[Vertex], faces: &[Face], look: bool) -> Result<Surface> {
    let properties = |element: &str| header.elements.get(element).map(|element| &element.properties);
    let has = |element: &str, name: &str| properties(element).is_some_and(|all| all.contains_key(name));
    let positions: Vec<[f64; 3]> = vertices.iter().map(|vertex| vertex.position).collect();
    let normals = has("vertex", "nx");
    let normals = normals.then(|| vertices.iter().map(|vertex| vertex.normal.map(|value| value as f32)).collect());
    // Two triangles from a quad are the most that is common.
    let mut triangles = Vec::with_capacity(faces.len());
    let mut splitter = Splitter::new();
    for (number, face) in faces.iter().enumerate() {
        corners(face)
            .and_then(|corners| splitter.split(&positions, &corners, &mut triangles))
            .map_err(|problem| SceneError::new(file, problem, MEND).at(format!("face {number}")))?;
    }
    if look {
        let plain = Surface { positions, normals, triangles, ..Surface::default() };
        return look::add(file, header, vertices, faces, plain);
    }
    let mut remarks = Vec::new();
    for (what, names) in
        [("vertex colours", ["red", "diffuse_red", "r"].as_slice()), ("texture coordinates", &["s", "u", "texture_u"])]
    {
        if names.iter().any(|name| has("vertex", name)) {
            remarks.push(format!("has {what}, which are not used"));
        }
    }
    for (what, name) in [("face colours", "red"), ("texture coordinates", "texcoord")] {
        if has("face", name) {
            remarks.push(format!("has {what}, which are not used"));
        }
    }
    Ok(Surface { positions, normals, triangles, remarks, look: None })
}

/// Checks all that can be known before the payload is read: above all that the announced counts fit into the file, so
/// that a damaged header costs neither memory nor time.
fn check_header(file: &str, header: &Header, payload: usize) -> Result<()> {
    let mut needed: usize = 0;
    for element in header.elements.values() {
        let bytes = element.count.saturating_mul(least_bytes(element, header.encoding));
        needed = needed.saturating_add(bytes);
        if needed > payload {
            let problem =
                format!("announces {} of them, which do not fit the {payload} bytes after the header", element.count);
            return Err(SceneError::new(file, problem, "the file is truncated or its header damaged: export it again")
                .at(format!("element {}", element.name)));
        }
    }
    let absent = |what: &str, mend: &str| SceneError::new(file, format!("has no {what}"), mend).at("header");
    let vertex = header.elements.get("vertex").ok_or_else(|| absent("element vertex", MEND))?;
    let face = header
        .elements
        .get("face")
        .ok_or_else(|| absent("element face", "export triangles: a point cloud or triangle strips cannot be used"))?;
    for name in ["x", "y", "z"] {
        match vertex.properties.get(name).map(|property| &property.data_type) {
            Some(PropertyType::Scalar(_)) => {}
            Some(PropertyType::List(..)) => return Err(absent(&format!("scalar property {name}"), MEND)),
            None => return Err(absent(&format!("vertex property {name}"), MEND)),
        }
    }
    let normals = ["nx", "ny", "nz"].iter().filter(|name| vertex.properties.contains_key(**name)).count();
    if normals != 0 && normals != 3 {
        return Err(absent("complete normals: only some of nx, ny, nz", "export all three, or none"));
    }
    let corners = CORNERS.iter().filter_map(|name| face.properties.get(*name));
    if corners.map(|property| &property.data_type).any(|kind| matches!(kind, PropertyType::Scalar(_))) {
        return Err(absent("list property vertex_indices", MEND));
    }
    if CORNERS.iter().filter(|name| face.properties.contains_key(**name)).count() != 1 {
        return Err(absent("single face property vertex_indices", MEND));
    }
    Ok(())
}

/// A lower bound on the size of one element in the file: in ascii, the end of its line.
fn least_bytes(element: &ElementDef, encoding: Encoding) -> usize {
    if encoding == Encoding::Ascii {
        return element.properties.len().max(1);
    }
    let properties = element.properties.values().map(|property| match &property.data_type {
        PropertyType::Scalar(scalar) => size(scalar),
        PropertyType::List(count, _) => size(count),
    });
    properties.sum::<usize>().max(1)
}

fn size(scalar: &ScalarType) -> usize {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

fn corners(face: &Face) -> std::result::Result<Vec<u32>, String> {
    match face.corners.len() {
        0 => Err("has no corners".to_owned()),
        1 | 2 => Err(format!("has {} corners, a face needs three", face.corners.len())),
        _ => face.corners.iter().map(|corner| vertex_index(*corner)).collect(),
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn vertex_index(value: f64) -> std::result::Result<u32, String> {
    if value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0 {
        Ok(value as u32)
    } else {
        Err(format!("names the vertex {value}"))
    }
}
