//! A mesh's file.

use super::text::{pairs, triples};
use crate::paint::Values;
use crate::part::Part;
use crate::ply::{Upwards, coordinate};

/// A stage whose default prim is the mesh: no subdivision, one-sided, with its normals where it has them, and texture
/// coordinates or `colours` where they vary it.
pub fn file(part: &Part, colours: Option<&Values>) -> String {
    let mesh = &part.mesh;
    let indices: Vec<String> = mesh.triangles.iter().flatten().map(u32::to_string).collect();
    let mut low = [f32::MAX; 3];
    let mut high = [f32::MIN; 3];
    for p in &mesh.positions {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    let normals = mesh.normals.as_ref().map_or(String::new(), |normals| {
        format!("    normal3f[] normals = {} (\n        interpolation = \"vertex\"\n    )\n", triples(normals))
    });
    let coordinates = part.coordinates.as_ref().map_or(String::new(), |all| {
        let all: Vec<[f32; 2]> = all.iter().map(|pair| coordinate(*pair, Upwards::Up)).collect();
        format!("    texCoord2f[] primvars:st = {} (\n        interpolation = \"vertex\"\n    )\n", pairs(&all))
    });
    let colours = match colours {
        Some(Values::Vertices(colours)) => format!(
            "    color3f[] primvars:displayColor = {} (\n        interpolation = \"vertex\"\n    )\n",
            triples(colours)
        ),
        _ => String::new(),
    };
    format!(
        "#usda 1.0\n(\n    defaultPrim = \"Mesh\"\n    metersPerUnit = 1\n    upAxis = \"Z\"\n)\n\ndef Mesh \"Mesh\"\n{{\n    \
         uniform token subdivisionScheme = \"none\"\n    uniform token orientation = \"rightHanded\"\n    \
         uniform bool doubleSided = 0\n    float3[] extent = {}\n    int[] faceVertexCounts = [{}]\n    \
         int[] faceVertexIndices = [{}]\n    point3f[] points = {}\n{normals}{coordinates}{colours}}}\n",
        triples(&[low, high]),
        vec!["3"; mesh.triangles.len()].join(", "),
        indices.join(", "),
        triples(&mesh.positions),
    )
}
