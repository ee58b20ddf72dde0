//! Every mesh format gives the same pyramid.

use gonio_scene::mesh::{self, Mesh, write_ply};

use crate::files;
use crate::fixture_meshes::{
    Encoding, Gltf, NORMALS, PLAIN, POSITIONS, PlyStyle, TRIANGLES, gltf_buffer, obj, ply, stl_ascii, stl_binary,
};

fn read(name: &str, bytes: &[u8]) -> Mesh {
    mesh::read(&files(&[(name, bytes)]), name).unwrap_or_else(|error| panic!("{error}"))
}

fn pyramid(normals: bool) -> Mesh {
    Mesh {
        positions: POSITIONS.to_vec(),
        normals: normals.then(|| NORMALS.to_vec()),
        triangles: vec![[0, 3, 2], [0, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
        degenerate: 0,
    }
}

/// The corners' positions and normals, triangle by triangle: what is left of a mesh when its indexing is ignored.
fn corners(mesh: &Mesh) -> Vec<[[f32; 3]; 2]> {
    let normal = |index: usize| mesh.normals.as_ref().map_or([0.0; 3], |normals| normals[index]);
    mesh.triangles.iter().flatten().map(|&index| [mesh.positions[index as usize], normal(index as usize)]).collect()
}

#[test]
fn ply_of_every_encoding_and_type() {
    for encoding in [Encoding::Ascii, Encoding::Little, Encoding::Big] {
        for normals in [false, true] {
            for (length, index) in [
                ("uchar", "int"),
                ("uint8", "uint"),
                ("char", "uchar"),
                ("ushort", "short"),
                ("int", "ushort"),
                ("uint32", "int8"),
                ("short", "float"),
                ("uchar", "double"),
            ] {
                for coordinate in ["float", "float32", "double"] {
                    let style = PlyStyle { encoding, coordinate, length, index, normals };
                    assert_eq!(read("a.ply", &ply(style)), pyramid(normals), "{style:?}");
                }
            }
        }
    }
}

#[test]
fn ply_written_and_read_keeps_every_bit() {
    for normals in [false, true] {
        let mesh = pyramid(normals);
        let bytes = write_ply(&mesh);
        assert_eq!(read("a.PLY", &bytes), mesh);
        assert_eq!(write_ply(&read("a.ply", &bytes)), bytes);
    }
}

#[test]
fn obj_with_and_without_normals() {
    for normals in [false, true] {
        let mesh = read("meshes/a.obj", &obj(normals));
        assert_eq!(corners(&mesh), corners(&pyramid(normals)));
        assert_eq!(mesh.normals.is_some(), normals);
        assert_eq!((mesh.positions.len(), mesh.degenerate), (5, 0));
    }
}

#[test]
fn obj_splits_a_vertex_whose_corners_have_different_normals() {
    let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvn 2 0 0\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2\n";
    let mesh = read("a.obj", text);
    assert_eq!(mesh.positions.len(), 6);
    assert_eq!(corners(&mesh)[0], [[0.0; 3], [0.0, 0.0, 1.0]]);
    assert_eq!(corners(&mesh)[3], [[0.0; 3], [1.0, 0.0, 0.0]], "normals are normalised");
}

#[test]
fn stl_joins_vertices_of_the_same_position() {
    // Many exporters begin a binary file as an ascii one.
    for bytes in [stl_binary("pyramid"), stl_binary("solid pyramid\n"), stl_ascii()] {
        let mesh = read("a.stl", &bytes);
        assert_eq!(corners(&mesh), corners(&pyramid(false)));
        assert_eq!((mesh.positions.len(), mesh.normals), (5, None));
    }
}

#[test]
fn gltf_of_every_container_and_index_type() {
    let primitives =
        [2, 3, 4].map(|indices| format!(r#"[{{"attributes":{{"POSITION":0,"NORMAL":1}},"indices":{indices}}}]"#));
    for primitives in primitives {
        let gltf = Gltf { primitives, ..Gltf::default() };
        assert_eq!(read("a.glb", &gltf.glb()), pyramid(true));
        assert_eq!(read("a.gltf", &gltf.embedded()), pyramid(true));
    }
    let plain = Gltf { primitives: r#"[{"attributes":{"POSITION":0},"indices":2}]"#.to_owned(), ..Gltf::default() };
    assert_eq!(read("a.glb", &plain.glb()), pyramid(false));
}

#[test]
fn gltf_finds_its_buffers_beside_itself() {
    let gltf = Gltf { uri: Some("data/the%20buffer.bin".to_owned()), ..Gltf::default() }.json();
    let path = "../meshes/a.gltf";
    let needed = mesh::dependencies(path, gltf.as_bytes()).unwrap();
    assert_eq!(needed, ["../meshes/data/the buffer.bin"]);
    let capture = files(&[(path, gltf.as_bytes()), (&needed[0], &gltf_buffer())]);
    assert_eq!(mesh::read(&capture, path).unwrap(), pyramid(true));

    assert!(mesh::dependencies("a.glb", &Gltf::default().glb()).unwrap().is_empty());
    assert!(mesh::dependencies("a.gltf", &Gltf::default().embedded()).unwrap().is_empty());
    assert!(mesh::dependencies("a.ply", &ply(PLAIN)).unwrap().is_empty());
}

#[test]
fn gltf_strips_and_fans() {
    // Four corners without an index: (0 1 2), then (1 3 2) as a strip and (0 2 3) as a fan.
    let views = r#"{"buffer":0,"byteLength":60},{"buffer":0,"byteLength":60},{"buffer":0,"byteOffset":120,"byteLength":18},
        {"buffer":0,"byteLength":248},{"buffer":0,"byteLength":248}"#;
    let expected = [(4, [[0, 1, 2], [2, 3, 4]]), (5, [[0, 1, 2], [1, 3, 2]]), (6, [[0, 1, 2], [0, 2, 3]])];
    for (mode, first_two) in expected {
        let primitives = format!(r#"[{{"attributes":{{"POSITION":0}},"mode":{mode}}}]"#);
        let mesh = read("a.glb", &Gltf { primitives, views: views.to_owned(), ..Gltf::default() }.glb());
        let found = &mesh.triangles[..first_two.len().min(mesh.triangles.len())];
        assert_eq!(found, &first_two[..found.len()], "mode {mode}");
        assert_eq!(mesh.triangles.len(), if mode == 4 { 1 } else { 3 }, "mode {mode}");
    }
}

#[test]
fn gltf_applies_the_transforms_of_its_nodes() {
    // Moved by (1, 2, 3), in a parent that doubles and mirrors x: x' = -2 (x + 1), y' = 2 (y + 2), z' = 2 (z + 3).
    let nodes = r#"[{"scale":[-2,2,2],"children":[1]},{"mesh":0,"translation":[1,2,3]}]"#.to_owned();
    let mesh = read("a.glb", &Gltf { nodes, ..Gltf::default() }.glb());
    for (found, [x, y, z]) in mesh.positions.iter().zip(POSITIONS) {
        let expected = [-2.0 * (x + 1.0), 2.0 * (y + 2.0), 2.0 * (z + 3.0)];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
    }
    for (found, [x, y, z]) in mesh.normals.as_ref().unwrap().iter().zip(NORMALS) {
        assert!(found.iter().zip([-x, y, z]).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
    // Mirrored, so wound the other way round: faces still show their outside.
    assert_eq!(mesh.triangles[0], [0, 2, 3]);
}

#[test]
fn gltf_turns_normals_by_the_inverse_transpose() {
    let nodes = r#"[{"mesh":0,"scale":[2,1,1]}]"#.to_owned();
    let mesh = read("a.glb", &Gltf { nodes, ..Gltf::default() }.glb());
    // (0.6, 0.8, 0) / (2, 1, 1), normalised.
    let length = (0.3f32 * 0.3 + 0.8 * 0.8).sqrt();
    let [x, y, _] = mesh.normals.unwrap()[2];
    assert!((x - 0.3 / length).abs() < 1e-6 && (y - 0.8 / length).abs() < 1e-6, "{x} {y}");
}

#[test]
fn gltf_gathers_instances_and_primitives() {
    let gltf = Gltf {
        nodes: r#"[{"children":[1,2]},{"mesh":0,"translation":[1,0,0]},{"mesh":0}]"#.to_owned(),
        primitives: r#"[{"attributes":{"POSITION":0,"NORMAL":1},"indices":2},{"attributes":{"POSITION":0,"NORMAL":1},"indices":4}]"#
            .to_owned(),
        ..Gltf::default()
    };
    let mesh = read("a.glb", &gltf.glb());
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (20, 24));
    assert_eq!(mesh.positions[10..15], POSITIONS, "the second instance stands where its own node puts it");
    assert_eq!(mesh.positions[4][0], POSITIONS[4][0] + 1.0);
    assert_eq!(mesh.triangles[23], TRIANGLES[5].map(|index| index + 15));
}

#[test]
fn triangles_without_area_are_counted_and_left_out() {
    let mut mesh = pyramid(true);
    mesh.triangles.extend([[0, 0, 1], [4, 4, 4]]);
    let found = read("a.ply", &write_ply(&mesh));
    assert_eq!((found.triangles.len(), found.degenerate), (6, 2));
}
