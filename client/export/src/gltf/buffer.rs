//! The binary part of a GLB: vertices, normals, tangents, indices.

use crate::matrix::{cross, unit};
use crate::paint::Values;
use crate::part::Part;
use serde_json::{Map, Value, json};

/// Component types and targets of glTF.
const UNSIGNED: u32 = 5125;
const FLOAT: u32 = 5126;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Bytes, and what says where they begin.
#[derive(Default)]
pub struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// The bytes of an image; index of their view.
    pub fn image(&mut self, bytes: &[u8]) -> usize {
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": length }));
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    /// A primitive of triangles of `material`, with `colours` where they are those of vertices. A mesh without normals is shaded by its faces, as glTF says of a primitive that has
    /// none. `tangents`, where wanted, are cross(z, normal) turned by so many radians about the normal.
    pub fn mesh(&mut self, part: &Part, colours: Option<&Values>, tangents: Option<f64>, material: usize) -> Value {
        let mesh = &part.mesh;
        let mut attributes = Map::new();
        let positions = self.vertices(&mesh.positions);
        let extreme = |start: f32, pick: fn(f32, f32) -> f32| {
            mesh.positions.iter().fold([start; 3], |m, p| [0, 1, 2].map(|k| pick(m[k], p[k])))
        };
        self.accessors[positions]["min"] = json!(extreme(f32::MAX, f32::min));
        self.accessors[positions]["max"] = json!(extreme(f32::MIN, f32::max));
        attributes.insert("POSITION".to_owned(), positions.into());
        if let Some(normals) = &mesh.normals {
            attributes.insert("NORMAL".to_owned(), self.vertices(normals).into());
            if let Some(turn) = tangents {
                let tangents: Vec<[f32; 4]> = normals.iter().map(|n| tangent(*n, turn)).collect();
                attributes.insert("TANGENT".to_owned(), self.vertices(&tangents).into());
            }
        }
        if let Some(coordinates) = &part.coordinates {
            attributes.insert("TEXCOORD_0".to_owned(), self.vertices(coordinates).into());
        }
        if let Some(Values::Vertices(colours)) = colours {
            attributes.insert("COLOR_0".to_owned(), self.vertices(colours).into());
        }
        let bytes: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|index| index.to_le_bytes()).collect();
        let view = self.view(&bytes, INDICES);
        let indices = self.accessor(view, UNSIGNED, mesh.triangles.len() * 3, "SCALAR");
        json!({ "attributes": attributes, "indices": indices, "material": material })
    }

    fn vertices<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes, VERTICES);
        self.accessor(view, FLOAT, values.len(), ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1])
    }

    fn view(&mut self, bytes: &[u8], target: u32) -> usize {
        // All of it is of four bytes or filled up to them, so that each part begins at a multiple of four.
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": length, "target": target }));
        self.bytes.extend_from_slice(bytes);
        self.views.len() - 1
    }

    fn accessor(&mut self, view: usize, component: u32, count: usize, kind: &str) -> usize {
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    /// A GLB whose JSON is `root` and this buffer's part of it.
    #[allow(clippy::cast_possible_truncation)] // A GLB holds at most 4 GiB, and no mesh file is above one.
    pub fn glb(self, mut root: Value) -> Vec<u8> {
        root["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        root["bufferViews"] = self.views.into();
        root["accessors"] = self.accessors.into();
        let mut text = root.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.bytes.len();
        let mut glb = Vec::with_capacity(length);
        glb.extend(b"glTF");
        glb.extend([2, length as u32].into_iter().flat_map(u32::to_le_bytes));
        for (kind, content) in [(b"JSON", &text), (b"BIN\0", &self.bytes)] {
            glb.extend((content.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(content);
        }
        glb
    }
}

/// The tangent of a highlight's long side, and the sign of its bitangent.
#[allow(clippy::cast_possible_truncation)]
fn tangent(normal: [f32; 3], turn: f64) -> [f32; 4] {
    let n = normal.map(f64::from);
    let across = cross([0.0, 0.0, 1.0], n);
    let along = if across.iter().map(|x| x * x).sum::<f64>() < 1e-12 { [1.0, 0.0, 0.0] } else { unit(across) };
    let beside = cross(n, along);
    let (sin, cos) = libm::sincos(turn);
    let [x, y, z] = unit([0, 1, 2].map(|k| cos * along[k] + sin * beside[k])).map(|x| x as f32);
    [x, y, z, 1.0]
}
