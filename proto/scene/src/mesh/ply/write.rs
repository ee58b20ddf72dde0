//! Writing PLY: the one mesh format that keeps every bit of a mesh, and nothing else.

use super::super::Mesh;

/// The mesh as a binary little-endian PLY file; [`read`](crate::mesh::read) gives back the same bits.
///
/// Triangles without an area are not in a [`Mesh`], so the count of them does not survive.
pub fn write_ply(mesh: &Mesh) -> Vec<u8> {
    let normals = if mesh.normals.is_some() { "property float nx\nproperty float ny\nproperty float nz\n" } else { "" };
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n{normals}\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len(),
    )
    .into_bytes();
    bytes.reserve(mesh.positions.len() * 24 + mesh.triangles.len() * 13);
    let mut put = |values: &[f32; 3]| bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    match &mesh.normals {
        None => mesh.positions.iter().for_each(put),
        Some(normals) => mesh.positions.iter().zip(normals).for_each(|(position, normal)| {
            put(position);
            put(normal);
        }),
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
    }
    bytes
}
