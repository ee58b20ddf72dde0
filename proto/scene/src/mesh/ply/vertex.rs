//! The elements of a PLY that make a surface.

use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

/// The names under which exporters write a face's corners.
pub(super) const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// The name under which they write a face's own texture coordinates, u and v of each corner.
pub(super) const WEDGES: [&str; 1] = ["texcoord"];

/// The names of a vertex's red, green, blue.
pub(super) const COLOURS: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];

/// The names of its texture coordinates.
pub(super) const COORDINATES: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];

/// Positions stay doubles until their rounding has been judged.
#[derive(Default)]
pub(super) struct Vertex {
    pub position: [f64; 3],
    pub normal: [f64; 3],
    /// As the file has it.
    pub colour: [f64; 3],
    pub coordinates: [f64; 2],
}

impl Vertex {
    pub fn slot(&mut self, name: &str) -> Option<&mut f64> {
        match name {
            "x" => Some(&mut self.position[0]),
            "y" => Some(&mut self.position[1]),
            "z" => Some(&mut self.position[2]),
            "nx" => Some(&mut self.normal[0]),
            "ny" => Some(&mut self.normal[1]),
            "nz" => Some(&mut self.normal[2]),
            "red" | "diffuse_red" | "r" => Some(&mut self.colour[0]),
            "green" | "diffuse_green" | "g" => Some(&mut self.colour[1]),
            "blue" | "diffuse_blue" | "b" => Some(&mut self.colour[2]),
            "s" | "u" | "texture_u" => Some(&mut self.coordinates[0]),
            "t" | "v" | "texture_v" => Some(&mut self.coordinates[1]),
            _ => None,
        }
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let shape = matches!(name, "x" | "y" | "z" | "nx" | "ny" | "nz");
        let Some(slot) = self.slot(name) else { return PropertyAccessResult::Ignored };
        let value = match value {
            Property::Double(value) => Some(value),
            Property::Int(value) => Some(f64::from(value)),
            Property::UInt(value) => Some(f64::from(value)),
            other => other.to_f32_lossy().map(f64::from),
        };
        match value {
            Some(value) => {
                *slot = value;
                PropertyAccessResult::Set
            }
            None if shape => PropertyAccessResult::UnsupportedType,
            // A list of colours is none that is known.
            None => PropertyAccessResult::Ignored,
        }
    }
}

/// A polygon. Indices of any type fit f64 exactly, so that a wrong one can be named as it stands in the file.
#[derive(Default)]
pub(super) struct Face {
    pub corners: Vec<f64>,
    /// u and v of each corner, where the face has them.
    pub wedges: Vec<f64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let into = if CORNERS.contains(&name) {
            &mut self.corners
        } else if WEDGES.contains(&name) {
            &mut self.wedges
        } else {
            return PropertyAccessResult::Ignored;
        };
        *into = match value {
            Property::ListChar(list) => list.into_iter().map(f64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(f64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(f64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(f64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(f64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(f64::from).collect(),
            Property::ListFloat(list) => list.into_iter().map(f64::from).collect(),
            Property::ListDouble(list) => list,
            _ if WEDGES.contains(&name) => return PropertyAccessResult::Ignored,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}
