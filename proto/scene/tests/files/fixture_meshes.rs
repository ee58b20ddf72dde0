//! The same small surface in every mesh format: a square pyramid whose coordinates no decimal hits exactly.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

pub const POSITIONS: [[f32; 3]; 5] =
    [[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 1e-3], [-0.1, 0.1, 0.0], [0.012_345_678, 0.0, 0.3]];

/// The base's fan and the four sides.
pub const TRIANGLES: [[u32; 3]; 6] = [[0, 3, 2], [0, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];

/// Unit to the last bit, so that nothing is normalised.
pub const NORMALS: [[f32; 3]; 5] =
    [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.6, -0.8], [0.0, 0.0, 1.0]];

#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Encoding {
    Ascii,
    Little,
    Big,
}

/// How a PLY file is written: the encoding, the types of its coordinates, list lengths and indices.
#[derive(Clone, Copy, Debug)]
pub struct PlyStyle {
    pub encoding: Encoding,
    pub coordinate: &'static str,
    pub length: &'static str,
    pub index: &'static str,
    pub normals: bool,
}

pub const PLAIN: PlyStyle =
    PlyStyle { encoding: Encoding::Little, coordinate: "float", length: "uchar", index: "int", normals: true };

fn put(bytes: &mut Vec<u8>, encoding: Encoding, kind: &str, value: f64) {
    let mut raw = match kind {
        "char" | "int8" => (value as i8).to_le_bytes().to_vec(),
        "uchar" | "uint8" => (value as u8).to_le_bytes().to_vec(),
        "short" | "int16" => (value as i16).to_le_bytes().to_vec(),
        "ushort" | "uint16" => (value as u16).to_le_bytes().to_vec(),
        "int" | "int32" => (value as i32).to_le_bytes().to_vec(),
        "uint" | "uint32" => (value as u32).to_le_bytes().to_vec(),
        "float" | "float32" => (value as f32).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    };
    match encoding {
        Encoding::Ascii if kind.starts_with("float") => bytes.extend(format!("{} ", value as f32).bytes()),
        Encoding::Ascii => bytes.extend(format!("{value} ").bytes()),
        Encoding::Little => bytes.append(&mut raw),
        Encoding::Big => bytes.extend(raw.iter().rev()),
    }
}

/// The pyramid with its base as one quad, and elements and properties around it that a reader has to pass over.
pub fn ply(style: PlyStyle) -> Vec<u8> {
    let PlyStyle { encoding, coordinate, length, index, normals } = style;
    let format = match encoding {
        Encoding::Ascii => "ascii",
        Encoding::Little => "binary_little_endian",
        Encoding::Big => "binary_big_endian",
    };
    let mut bytes =
        format!("ply\nformat {format} 1.0\ncomment a pyramid\nelement camera 1\nproperty double f\n").into_bytes();
    bytes.extend(format!("element vertex 5\nproperty {coordinate} x\nproperty uchar red\n").bytes());
    bytes.extend(format!("property {coordinate} y\nproperty {coordinate} z\n").bytes());
    if normals {
        bytes.extend("nx ny nz".split(' ').flat_map(|name| format!("property {coordinate} {name}\n").into_bytes()));
    }
    bytes.extend(
        format!("element face 5\nproperty int material\nproperty list {length} {index} vertex_indices\n").bytes(),
    );
    bytes.extend_from_slice(b"end_header\n");
    let end = |bytes: &mut Vec<u8>| {
        if encoding == Encoding::Ascii {
            bytes.push(b'\n');
        }
    };
    put(&mut bytes, encoding, "double", 35.0);
    end(&mut bytes);
    for (position, normal) in POSITIONS.iter().zip(NORMALS) {
        put(&mut bytes, encoding, coordinate, position[0].into());
        put(&mut bytes, encoding, "uchar", 200.0);
        put(&mut bytes, encoding, coordinate, position[1].into());
        put(&mut bytes, encoding, coordinate, position[2].into());
        for value in normal.into_iter().filter(|_| normals) {
            put(&mut bytes, encoding, coordinate, value.into());
        }
        end(&mut bytes);
    }
    let faces: [&[u32]; 5] = [&[0, 3, 2, 1], &TRIANGLES[2], &TRIANGLES[3], &TRIANGLES[4], &TRIANGLES[5]];
    for face in faces {
        put(&mut bytes, encoding, "int", -7.0);
        put(&mut bytes, encoding, length, face.len() as f64);
        for &corner in face {
            put(&mut bytes, encoding, index, corner.into());
        }
        end(&mut bytes);
    }
    bytes
}

/// The pyramid in OBJ, with a name that is not UTF-8, with negative indices, texture coordinates and a polyline.
pub fn obj(normals: bool) -> Vec<u8> {
    let mut text = b"# pyramid\nmtllib nowhere.mtl\no caf\xe9\n".to_vec();
    for [x, y, z] in POSITIONS {
        text.extend(format!("v {x} {y} {z}\n").bytes());
    }
    for [x, y, z] in NORMALS.into_iter().filter(|_| normals) {
        text.extend(format!("  vn {x} {y} {z}\n").bytes());
    }
    text.extend_from_slice(b"vt 0 0\nvt 1 1\ng base\n");
    let corner = |index: i32| if normals { format!(" {index}/1/{index}") } else { format!(" {index}/2") };
    text.extend(format!("f{}{}{}{}\n", corner(1), corner(4), corner(3), corner(2)).bytes());
    text.extend_from_slice(b"l 1 2 3\np 1\nusemtl sides\ng sides\n");
    for [a, b, c] in [[1, 2, 5], [2, 3, 5], [3, 4, 5], [4, 1, 5]] {
        // Counted backwards from the last vertex.
        text.extend(format!("f{}{}{}\r\n", corner(a - 6), corner(b), corner(c)).bytes());
    }
    text
}

pub fn stl_binary(title: &str) -> Vec<u8> {
    let mut bytes = title.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend((TRIANGLES.len() as u32).to_le_bytes());
    for triangle in TRIANGLES {
        let corners = triangle.map(|index| POSITIONS[index as usize]);
        bytes.extend([[0.0f32; 3], corners[0], corners[1], corners[2]].iter().flatten().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

pub fn stl_ascii() -> Vec<u8> {
    let mut text = "solid pyramid\n".to_owned();
    for triangle in TRIANGLES {
        text += " facet normal 0 0 0\n  outer loop\n";
        for [x, y, z] in triangle.map(|index| POSITIONS[index as usize]) {
            text += &format!("   vertex {x:e} {y:e} {z:e}\n");
        }
        text += "  endloop\n endfacet\n";
    }
    (text + "endsolid pyramid\n").into_bytes()
}

/// The buffer of the glTF files: positions, normals, then indices as u8 (padded), u16 (padded) and u32.
pub fn gltf_buffer() -> Vec<u8> {
    let mut bytes: Vec<u8> = POSITIONS.iter().chain(&NORMALS).flatten().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend(TRIANGLES.iter().flatten().map(|&index| index as u8));
    bytes.extend([0; 2]);
    bytes.extend(TRIANGLES.iter().flatten().flat_map(|&index| (index as u16).to_le_bytes()));
    bytes.extend(TRIANGLES.iter().flatten().flat_map(|&index| index.to_le_bytes()));
    bytes
}

/// The parts of a glTF document that tests vary.
#[derive(Clone)]
pub struct Gltf {
    pub uri: Option<String>,
    pub nodes: String,
    pub primitives: String,
    pub views: String,
    pub extra: String,
}

impl Default for Gltf {
    fn default() -> Self {
        let view =
            |offset: usize, length: usize| format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#);
        Self {
            uri: None,
            nodes: r#"[{"mesh":0}]"#.to_owned(),
            primitives: r#"[{"attributes":{"POSITION":0,"NORMAL":1},"indices":3}]"#.to_owned(),
            views: [view(0, 60), view(60, 60), view(120, 18), view(140, 36), view(176, 72)].join(","),
            extra: String::new(),
        }
    }
}

impl Gltf {
    pub fn json(&self) -> String {
        let uri = self.uri.as_ref().map(|uri| format!(r#""uri":"{uri}","#)).unwrap_or_default();
        let Self { nodes, primitives, views, extra, .. } = self;
        format!(
            r#"{{"asset":{{"version":"2.0"}},{extra}"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":{nodes},
            "meshes":[{{"primitives":{primitives}}}],"buffers":[{{{uri}"byteLength":248}}],"bufferViews":[{views}],
            "accessors":[
              {{"bufferView":0,"componentType":5126,"count":5,"type":"VEC3","min":[-0.1,-0.1,0],"max":[0.1,0.1,0.3]}},
              {{"bufferView":1,"componentType":5126,"count":5,"type":"VEC3"}},
              {{"bufferView":2,"componentType":5121,"count":18,"type":"SCALAR"}},
              {{"bufferView":3,"componentType":5123,"count":18,"type":"SCALAR"}},
              {{"bufferView":4,"componentType":5125,"count":18,"type":"SCALAR"}}]}}"#
        )
    }

    /// As a `.gltf` file with the buffer inside.
    pub fn embedded(mut self) -> Vec<u8> {
        self.uri = Some(format!("data:application/octet-stream;base64,{}", STANDARD.encode(gltf_buffer())));
        self.json().into_bytes()
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let binary = gltf_buffer();
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        bytes
    }
}
