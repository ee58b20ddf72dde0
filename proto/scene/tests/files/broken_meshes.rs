//! Every broken mesh gets an error that names its file and what to do.

use gonio_scene::mesh::{self, Mesh, write_ply};

use crate::files;
use crate::fixture_meshes::{
    Encoding, Gltf, NORMALS, PLAIN, POSITIONS, PlyStyle, TRIANGLES, gltf_buffer, stl_ascii, stl_binary,
};

/// The file is refused, the error names it and the place, and says what is expected here.
fn refused(name: &str, bytes: &[u8], says: &str) {
    let error = mesh::read(&files(&[(name, bytes)]), name).expect_err(says);
    let line = error.to_string();
    assert!(error.file == name && line.starts_with(name), "{line}");
    assert!(!error.mend.is_empty() && !line.contains('\n'), "{line}");
    assert!(line.contains(says), "expected {says:?} in: {line}");
}

fn ascii(header: &str, body: &str) -> Vec<u8> {
    format!("ply\nformat ascii 1.0\n{header}end_header\n{body}").into_bytes()
}

const XYZ: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const FACE: &str = "element face 1\nproperty list uchar int vertex_indices\n";
const VERTICES: &str = "0 0 0\n1 0 0\n0 1 0\n";

fn triangle_ply(vertices: &str, face: &str) -> Vec<u8> {
    ascii(&format!("{XYZ}{FACE}"), &format!("{vertices}{face}\n"))
}

fn with(change: impl FnOnce(&mut Mesh)) -> Vec<u8> {
    let mut mesh = Mesh {
        positions: POSITIONS.to_vec(),
        normals: Some(NORMALS.to_vec()),
        triangles: TRIANGLES.to_vec(),
        degenerate: 0,
    };
    change(&mut mesh);
    write_ply(&mesh)
}

fn edit(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let at = bytes.windows(from.len()).position(|window| window == from.as_bytes()).unwrap();
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

#[test]
fn files_that_are_something_else() {
    refused("a.ply", b"", "is empty");
    refused("a.txt", b"ply\n", "extension");
    refused("ply", b"ply\n", "extension");
    refused("folder.ply/a", b"ply\n", "extension");
    refused("a.ply", &stl_binary("pyramid"), "does not begin as a Ply");
    refused("a.stl", &crate::fixture_meshes::ply(PLAIN), "is a Ply file");
    refused("a.obj", &Gltf::default().glb(), "is a Glb file");
    refused("a.gltf", &Gltf::default().glb(), "is a Glb file");
    refused("a.glb", &Gltf::default().embedded(), "is a Gltf file");
    refused("a.obj", &stl_ascii(), "is a Stl file");
    assert!(mesh::read(&files(&[]), "nowhere.ply").unwrap_err().to_string().contains("nowhere.ply"));
}

#[test]
fn meshes_that_cannot_be_rendered() {
    refused("a.ply", &with(|mesh| mesh.triangles.clear()), "has no faces");
    refused("a.ply", &with(|mesh| mesh.triangles[3] = [0, 1, 5]), "triangle 3: joins the vertices [0, 1, 5]");
    refused("a.ply", &with(|mesh| mesh.positions[2][1] = f32::NAN), "vertex 2: has the position");
    refused("a.ply", &with(|mesh| mesh.positions[4][0] = f32::NEG_INFINITY), "vertex 4");
    refused("a.ply", &with(|mesh| mesh.normals.as_mut().unwrap()[1] = [0.0; 3]), "vertex 1: has the normal");
    refused("a.ply", &with(|mesh| mesh.normals.as_mut().unwrap()[3][2] = f32::NAN), "vertex 3: has the normal");
    refused("a.ply", &with(|mesh| mesh.positions = vec![[0.5; 3]; 5]), "none has an area");
    refused("a.ply", &with(|mesh| mesh.triangles = vec![[0, 0, 1], [2, 2, 2]]), "has 2 triangles and none");
    refused("a.ply", &with(|mesh| mesh.positions.iter_mut().flatten().for_each(|x| *x *= 1e8)), "bounding box: is");
    refused("a.ply", &with(|mesh| mesh.positions.iter_mut().flatten().for_each(|x| *x *= 1e-10)), "in metres");
}

#[test]
fn ply() {
    refused("a.ply", b"ply\nformat ascii 1.0\nelement vertex 1\n", "end_header");
    refused("a.ply", b"ply\nformat ascii 2.0\nend_header\n", "header");
    refused("a.ply", b"ply\nformat binary_middle_endian 1.0\nend_header\n", "header: Line 2");
    refused("a.ply", b"ply\nend_header\n", "format");
    refused("a.ply", &ascii(XYZ, VERTICES), "element face");
    refused("a.ply", &ascii(FACE, "3 0 1 2\n"), "element vertex");
    refused(
        "a.ply",
        &ascii(&format!("{XYZ}{FACE}").replace("float z", "float w"), &format!("{VERTICES}3 0 1 2\n")),
        "property z",
    );
    refused(
        "a.ply",
        &ascii(&format!("{XYZ}property float nx\n{FACE}"), "0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n"),
        "normals",
    );
    refused(
        "a.ply",
        &ascii(&format!("{XYZ}{FACE}").replace("indices", "numbers"), &format!("{VERTICES}3 0 1 2\n")),
        "vertex_indices",
    );
    refused(
        "a.ply",
        &ascii(&format!("{XYZ}{FACE}").replace("list uchar int", "int"), &format!("{VERTICES}3\n")),
        "list property vertex_indices",
    );
    refused("a.ply", &triangle_ply(VERTICES, "3 0 1 3"), "joins the vertices [0, 1, 3]");
    refused("a.ply", &triangle_ply(VERTICES, "3 0 1 -1"), "face 0: names the vertex -1");
    refused("a.ply", &triangle_ply(VERTICES, "2 0 1"), "face 0: has 2 corners");
    refused("a.ply", &triangle_ply(VERTICES, "0"), "face 0: has no corners");
    refused("a.ply", &triangle_ply(VERTICES, "3 0 1"), "element face: Line 13");
    refused("a.ply", &triangle_ply("0 0 0\n1 zero 0\n0 1 0\n", "3 0 1 2"), "element vertex: Line 11");
    refused("a.ply", &triangle_ply("0 0 0\n1 nan 0\n0 1 0\n", "3 0 1 2"), "vertex 1: has the position");
    refused("a.ply", &triangle_ply("0 0 0\n1 1e99 0\n0 1 0\n", "3 0 1 2"), "vertex 1");
    refused("a.ply", &triangle_ply(VERTICES, "3 0 1 2\n3 0 1 2"), "more than its header announces");
    let absurd = ascii(&format!("{XYZ}{FACE}").replace("vertex 3", "vertex 999999999999"), VERTICES);
    refused("a.ply", &absurd, "announces 999999999999");
    // An element without properties takes no bytes, and could be announced any number of times.
    let hollow = ascii(&format!("element nothing 18446744073709551615\n{XYZ}{FACE}"), &format!("{VERTICES}3 0 1 2\n"));
    refused("a.ply", &hollow, "element nothing");
    let whole = crate::fixture_meshes::ply(PLAIN);
    refused("a.ply", &whole[..whole.len() - 1], "element face");
    refused("a.ply", &whole[..whole.len() - 70], "element face: announces 5");
    refused("a.ply", &edit(&whole, "vertex 5", "vertex 4"), "a.ply");
    let lists = PlyStyle { length: "int", encoding: Encoding::Big, ..PLAIN };
    let mut negative = crate::fixture_meshes::ply(lists);
    let last_length = negative.len() - 16;
    negative[last_length] = 0xff;
    refused("a.ply", &negative, "element face");
}

#[test]
fn stl() {
    let whole = stl_binary("pyramid");
    refused("a.stl", &whole[..whole.len() - 1], "header: announces 6 triangles");
    refused("a.stl", &whole[..50], "header");
    refused("a.stl", &[&whole[..80], &[0xff; 4], &whole[84..]].concat(), "announces 4294967295");
    refused("a.stl", &[&whole[..80], &[0; 4]].concat(), "has no faces");
    let mut broken = whole.clone();
    broken[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    refused("a.stl", &broken, "vertex 0: has the position");
    let text = String::from_utf8(stl_ascii()).unwrap();
    refused("a.stl", text.replacen("3e-1", "", 1).as_bytes(), "line 20: has a vertex that is not three numbers");
    refused("a.stl", text.replacen("endloop", "vertex 9 9 9\nendloop", 1).as_bytes(), "ends a facet of 4 corners");
    refused("a.stl", text.replacen("endloop", "endlop", 1).as_bytes(), "line 7: begins with a word");
    refused("a.stl", &text.as_bytes()[..text.len() / 2], "a.stl");
    refused("a.stl", text.replace("endsolid pyramid", "").as_bytes(), "endsolid");
    refused("a.stl", text.replace("3e-1", "x").as_bytes(), "a.stl");
    refused("a.stl", b"solid nothing\nendsolid nothing\n", "has no faces");
}

#[test]
fn obj() {
    let text = |faces: &str| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n{faces}\n").into_bytes();
    refused("a.obj", b"# nothing\n", "has no faces");
    refused("a.obj", &text("l 1 2 3"), "has no faces");
    refused("a.obj", &text("f 1 2 4"), "face: face vertex index out of bounds");
    refused("a.obj", &text("f 0 1 2"), "out of bounds");
    refused("a.obj", &text("f 1 2 -9"), "out of bounds");
    refused("a.obj", &text("f 1//1 2//1 3//2"), "face: face normal index out of bounds");
    refused("a.obj", &text("# comment\n\nf 1 2 x"), "line 7: face parse error");
    refused("a.obj", &text("f 1//1 2//1 3"), "faces with normals and faces without");
    refused("a.obj", &text("f 1//1 2//1 3//1\no other\nf 1 3 2"), "faces with normals and faces without");
    refused("a.obj", &text("v 1 2\nf 1 2 3"), "line 5: position parse error");
    refused("a.obj", &text("v 1 2 nan\nf 1 2 3\nf 1 2 4"), "vertex 3: has the position");
    refused("a.obj", &text("f"), "a.obj");
    refused("a.obj", &text("f 1 2"), "none has an area");
}

#[test]
fn gltf() {
    let plain = Gltf::default();
    let whole = plain.glb();
    let refused_glb = |change: &dyn Fn(&mut Gltf), says: &str| {
        let mut gltf = Gltf::default();
        change(&mut gltf);
        refused("a.glb", &gltf.glb(), says);
    };
    refused("a.glb", &whole[..whole.len() - 1], "header: announces");
    refused("a.glb", b"glTF\x02\0\0\0", "header");
    refused("a.glb", &edit(&whole, "BIN\0", "BAN\0"), "unknown chunk");
    refused("a.glb", &edit(&whole, r#""scene":0"#, r#""scene":7"#), "scene");
    refused("a.glb", &edit(&whole, r#""scenes":["#, r#""sceneS":["#), "scene");
    refused("a.gltf", b"{", "json: ");
    refused("a.gltf", &plain.json().into_bytes(), "buffers[0]: refers to a binary chunk");
    refused_glb(
        &|gltf| gltf.extra = r#""extensionsRequired":["KHR_draco_mesh_compression"],"#.into(),
        "KHR_draco_mesh_compression",
    );
    refused_glb(&|gltf| gltf.nodes = r#"[{"children":[1]},{"children":[0]}]"#.into(), "contain each other");
    refused_glb(&|gltf| gltf.nodes = r#"[{"mesh":1}]"#.into(), "nodes[0].mesh");
    refused_glb(&|gltf| gltf.nodes = "[{}]".into(), "has no faces");
    refused_glb(&|gltf| gltf.nodes = r#"[{"mesh":0,"scale":[1,0,1]}]"#.into(), "nodes[0]: has a transform");
    refused_glb(&|gltf| gltf.nodes = r#"[{"mesh":0,"scale":[1e30,1e30,1]}]"#.into(), "a.glb");
    let primitive = |text: &'static str| move |gltf: &mut Gltf| gltf.primitives = text.to_owned();
    refused_glb(&primitive(r#"[{"attributes":{"POSITION":0},"indices":3,"mode":1}]"#), "has no faces");
    refused_glb(&primitive(r#"[{"attributes":{"NORMAL":1},"indices":3}]"#), "POSITION");
    refused_glb(&primitive(r#"[{"attributes":{"POSITION":9},"indices":3}]"#), "accessors[9], which is not there");
    refused_glb(
        &primitive(r#"[{"attributes":{"POSITION":0},"indices":1}]"#),
        "accessors[1]: is Vec3 of F32, which is no index",
    );
    refused_glb(&primitive(r#"[{"attributes":{"POSITION":0,"NORMAL":2},"indices":3}]"#), "accessors[2]");
    let morph = r#"[{"attributes":{"POSITION":0},"indices":3,"targets":[{"POSITION":1}]}]"#;
    refused_glb(&primitive(morph), "morph targets");
    let view =
        |from: &'static str, to: &'static str| move |gltf: &mut Gltf| gltf.views = gltf.views.replacen(from, to, 1);
    refused_glb(&view(r#""byteLength":60"#, r#""byteLength":59"#), "accessors[0]: has 5 elements");
    refused_glb(&view(r#""byteLength":36"#, r#""byteLength":109"#), "accessors[3]: has 18 elements");
    refused_glb(&view(r#""byteLength":60"#, r#""byteLength":60,"byteStride":8"#), "overlap");
    refused_glb(&view(r#""byteOffset":0"#, r#""byteOffset":18446744073709551615"#), "a.glb");
    // The third view read as 16-bit indices: some of them name vertices that do not exist.
    refused_glb(&view(r#""byteOffset":140"#, r#""byteOffset":100"#), "names the vertex");
}

#[test]
fn gltf_with_separate_buffers() {
    let json = |uri: &str| Gltf { uri: Some(uri.to_owned()), ..Gltf::default() }.json().into_bytes();
    refused("a.gltf", &json("data:application/octet-stream;base64,AAA"), "buffers[0]: has a damaged data URI");
    refused("a.gltf", &json("data:text/plain,AAAA"), "buffers[0]: has a data URI that is not base64");
    refused("a.gltf", &json("data:application/octet-stream;base64,AAAA"), "buffers[0]: has 3 bytes of the 248");
    refused("a.gltf", &json("https://example.com/part.bin"), "no file beside it");
    refused("a.gltf", &json("file:///etc/passwd"), "no file beside it");
    refused("a.gltf", &json("%ff.bin"), "a name that is none");
    // What is missing is the buffer: the error names that file.
    let error = mesh::read(&files(&[("a.gltf", &json("part.bin"))]), "a.gltf").unwrap_err();
    assert_eq!(error.file, "part.bin");
    let short = files(&[("a.gltf", &json("part.bin")), ("part.bin", &gltf_buffer()[..200])]);
    let error = mesh::read(&short, "a.gltf").unwrap_err();
    assert!(error.to_string().contains("200 bytes of the 248"), "{error}");
    assert!(mesh::dependencies("a.gltf", b"{").unwrap_err().to_string().starts_with("a.gltf"));
}

#[test]
fn the_fixtures_themselves_are_sound() {
    assert!(mesh::read(&files(&[("a.ply", &with(|_| ()))]), "a.ply").is_ok());
    assert!(mesh::read(&files(&[("a.ply", &triangle_ply(VERTICES, "3 0 1 2"))]), "a.ply").is_ok());
    assert!(mesh::read(&files(&[("a.obj", &crate::fixture_meshes::obj(true))]), "a.obj").is_ok());
}
