//! Meshes as PLY files, with what a part's maps need.

use crate::paint::Values;
use crate::part::Part;
use std::fmt::Write;

/// Which way texture coordinates count up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Upwards {
    /// v = 0 is the image's first row.
    Down,
    /// v = 0 is the image's last row.
    Up,
}

/// A part as binary little-endian PLY: positions, normals where it has them, `u` and `v` where a texture varies it, and
/// `r`, `g`, `b` (linear, 32-bit floats) where `colours` are the values of its vertices.
pub fn write(part: &Part, colours: Option<&Values>, upwards: Upwards) -> Vec<u8> {
    let mesh = &part.mesh;
    let colours = match colours {
        Some(Values::Vertices(colours)) => Some(colours),
        _ => None,
    };
    let columns: Vec<&str> = ["x", "y", "z"]
        .into_iter()
        .chain(mesh.normals.is_some().then_some(["nx", "ny", "nz"]).into_iter().flatten())
        .chain(part.coordinates.is_some().then_some(["u", "v"]).into_iter().flatten())
        .chain(colours.is_some().then_some(["r", "g", "b"]).into_iter().flatten())
        .collect();
    let mut head = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.positions.len());
    for column in &columns {
        // Writing to a string cannot fail.
        let _ = writeln!(head, "property float {column}");
    }
    let _ =
        writeln!(head, "element face {}\nproperty list uchar uint vertex_indices\nend_header", mesh.triangles.len());
    let mut bytes = head.into_bytes();
    bytes.reserve(mesh.positions.len() * columns.len() * 4 + mesh.triangles.len() * 13);
    for vertex in 0..mesh.positions.len() {
        let mut put = |values: &[f32]| bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        put(&mesh.positions[vertex]);
        if let Some(normals) = &mesh.normals {
            put(&normals[vertex]);
        }
        if let Some(coordinates) = &part.coordinates {
            put(&coordinate(coordinates[vertex], upwards));
        }
        if let Some(colours) = colours {
            put(&colours[vertex]);
        }
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
    }
    bytes
}

/// A texture coordinate whose v counts down, as a format has it.
pub fn coordinate([u, v]: [f32; 2], upwards: Upwards) -> [f32; 2] {
    [u, if upwards == Upwards::Up { 1.0 - v } else { v }]
}
