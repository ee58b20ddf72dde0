//! Vertex colours as a texture, for renderers without them.
//!
//! Each triangle gets 2 x 2 texels. Its corners lie in the middles of three of them, which hold the corners' colours; the fourth
//! holds b + c - a. What is bilinear between four such texels is linear over the triangle: the texture shows what vertex colours
//! show, to the last bit of its floats.

use crate::part::Part;
use gonio_scene::image::Image;
use gonio_scene::mesh::Mesh;
use std::sync::Arc;

/// The fourth texel of a triangle.
pub fn fourth([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    [0, 1, 2].map(|k| b[k] + c[k] - a[k])
}

/// `part`, whose vertices have `colours`, with vertices of each triangle's own, coordinates and the texture.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)] // Vertices are below 2^32, texels below 2^24 a side.
pub fn unwrap(part: Part, colours: &[[f32; 3]]) -> Part {
    let mesh = &part.mesh;
    let count = mesh.triangles.len();
    let columns = (1..).find(|side| side * side >= count).unwrap_or(1);
    let (width, height) = (2 * columns, 2 * count.div_ceil(columns));
    let mut pixels = vec![[0.0; 3]; width * height];
    let mut coordinates = Vec::with_capacity(3 * count);
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let (x, y) = (2 * (index % columns), 2 * (index / columns));
        let corners = triangle.map(|vertex| colours[vertex as usize]);
        let places = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        let texels = [corners[0], corners[1], corners[2], fourth(corners)];
        for ((x, y), texel) in places.into_iter().zip(texels) {
            pixels[y * width + x] = texel;
        }
        coordinates.extend(
            places[..3].iter().map(|(x, y)| [(*x as f32 + 0.5) / width as f32, (*y as f32 + 0.5) / height as f32]),
        );
    }
    let corner = |values: &[[f32; 3]]| mesh.triangles.iter().flatten().map(|v| values[*v as usize]).collect::<Vec<_>>();
    let split = Mesh {
        positions: corner(&mesh.positions),
        normals: mesh.normals.as_deref().map(corner),
        triangles: (0..count as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect(),
        degenerate: 0,
    };
    let image = Image { width: width as u32, height: height as u32, pixels };
    let paint = part.paint.with_atlas(&Arc::new(image));
    Part { paint, coordinates: Some(coordinates), mesh: Arc::new(split), ..part }
}
