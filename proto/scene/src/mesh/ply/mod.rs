//! PLY: Stanford polygon files, ascii and binary.

mod write;

pub use write::write_ply;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::Surface;
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

const MEND: &str = "export the mesh again, as a binary PLY";

/// The names under which exporters write a face's corners.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

#[derive(Default)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let slot = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            "nx" => &mut self.normal[0],
            "ny" => &mut self.normal[1],
            "nz" => &mut self.normal[2],
            _ => return PropertyAccessResult::Ignored,
        };
        match value.to_f32_lossy() {
            Some(value) => {
                *slot = value;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}

/// A polygon. Indices of any type fit f64 exactly, so that a wrong one can be named as it stands in the file.
#[derive(Default)]
struct Face(Vec<f64>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !CORNERS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match value {
            Property::ListChar(list) => list.into_iter().map(f64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(f64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(f64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(f64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(f64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(f64::from).collect(),
            Property::ListFloat(list) => list.into_iter().map(f64::from).collect(),
            Property::ListDouble(list) => list,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element of no concern (edges, materials...), read to get past it.
struct Passed;

impl PropertyAccess for Passed {
    fn new() -> Self {
        Self
    }
}

/// Reads a PLY file's `vertex` and `face` elements; polygons become fans around their first corner.
pub(super) fn read(file: &str, bytes: &[u8]) -> Result<Surface> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Passed>::new()
        .read_header(&mut reader)
        .map_err(|error| SceneError::new(file, one_line(&error), MEND).at("header"))?;
    check_header(file, &header, reader.get_ref().len())?;

    let mut surface = Surface::default();
    for element in header.elements.values() {
        let broken =
            |error: ParseError| SceneError::new(file, one_line(&error), MEND).at(format!("element {}", element.name));
        match element.name.as_str() {
            "vertex" => {
                let vertices = Parser::<Vertex>::new();
                let vertices = vertices.read_payload_for_element(&mut reader, element, &header).map_err(broken)?;
                surface.positions = vertices.iter().map(|vertex| vertex.position).collect();
                if element.properties.contains_key("nx") {
                    surface.normals = Some(vertices.iter().map(|vertex| vertex.normal).collect());
                }
            }
            "face" => {
                let faces =
                    Parser::<Face>::new().read_payload_for_element(&mut reader, element, &header).map_err(broken)?;
                // Two triangles from a quad are the most that is common.
                surface.triangles.reserve(faces.len());
                for (number, face) in faces.iter().enumerate() {
                    fan(face, &mut surface.triangles)
                        .map_err(|problem| SceneError::new(file, problem, MEND).at(format!("face {number}")))?;
                }
            }
            _ => {
                let passed = Parser::<Passed>::new();
                passed.read_payload_for_element(&mut reader, element, &header).map_err(broken)?;
            }
        }
    }
    let left = reader.get_ref();
    if !left.iter().all(u8::is_ascii_whitespace) {
        let problem = format!("has {} bytes more than its header announces", left.len());
        return Err(SceneError::new(file, problem, MEND).at("header"));
    }
    Ok(surface)
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

fn fan(Face(corners): &Face, triangles: &mut Vec<[u32; 3]>) -> std::result::Result<(), String> {
    let [first, rest @ ..] = corners.as_slice() else {
        return Err("has no corners".to_owned());
    };
    if rest.len() < 2 {
        return Err(format!("has {} corners, a face needs three", corners.len()));
    }
    let first = vertex_index(*first)?;
    let mut previous = None;
    for &corner in rest {
        let corner = vertex_index(corner)?;
        if let Some(previous) = previous {
            triangles.push([first, previous, corner]);
        }
        previous = Some(corner);
    }
    Ok(())
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn vertex_index(value: f64) -> std::result::Result<u32, String> {
    if value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0 {
        Ok(value as u32)
    } else {
        Err(format!("names the vertex {value}"))
    }
}
