//! Meshes as people and their programs write them: what is right in another spelling is read, what is not used does not
//! matter.

use gonio_scene::mesh::{self, Mesh};

use crate::files;
use crate::fixture_meshes::{Gltf, POSITIONS, TRIANGLES, obj, stl_ascii};

fn read(name: &str, bytes: &[u8]) -> Mesh {
    mesh::read(&files(&[(name, bytes)]), name).unwrap_or_else(|error| panic!("{error}"))
}

fn remarks(name: &str, bytes: &[u8]) -> Vec<String> {
    mesh::read_with_remarks(&files(&[(name, bytes)]), name).unwrap_or_else(|error| panic!("{error}")).1
}

/// The corners' positions, triangle by triangle.
fn corners(mesh: &Mesh) -> Vec<[f32; 3]> {
    mesh.triangles.iter().flatten().map(|&index| mesh.positions[index as usize]).collect()
}

fn pyramid() -> Vec<[f32; 3]> {
    TRIANGLES.iter().flatten().map(|&index| POSITIONS[index as usize]).collect()
}

/// Twice the area of every triangle that looks up along z: of a flat face, what it covers.
fn covered(mesh: &Mesh) -> f64 {
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|index| mesh.positions[index as usize].map(f64::from));
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let areas: Vec<f64> = mesh.triangles.iter().map(area).collect();
    assert!(areas.iter().all(|area| *area > 0.0), "{areas:?}");
    areas.iter().sum()
}

const ELL: &str = "0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n";

fn ell_ply(faces: usize, body: &str) -> Vec<u8> {
    let header = "ply\nformat ascii 1.0\nelement vertex 6\nproperty double x\nproperty double y\nproperty double z\n";
    format!("{header}element face {faces}\nproperty list uchar int vertex_indices\nend_header\n{ELL}{body}")
        .into_bytes()
}

#[test]
fn concave_polygons_are_cut_inside() {
    // A fan around any corner but the fourth leaves the L.
    assert!((covered(&read("a.ply", &ell_ply(1, "6 4 5 0 1 2 3\n"))) - 6.0).abs() < 1e-9);
    let vertices: String = ELL.lines().map(|line| format!("v {line}\n")).collect();
    assert!((covered(&read("a.obj", format!("{vertices}f 5 6 1 2 3 4\n").as_bytes())) - 6.0).abs() < 1e-9);
    let crossed = mesh::read(&files(&[("a.ply", &ell_ply(1, "6 0 2 1 3 4 5\n"))]), "a.ply").unwrap_err().to_string();
    assert!(crossed.contains("face 0: is a polygon of 6 corners whose outline crosses itself"), "{crossed}");
}

#[test]
fn an_obj_may_go_on_in_the_next_line_and_begin_with_a_mark() {
    let text = String::from_utf8_lossy(&obj(false)).into_owned();
    let continued: String = text
        .lines()
        .map(|line| match line.rsplit_once(' ') {
            Some((start, end)) if line.starts_with(['f', 'v']) => format!("{start} \\\r\n  {end}\r\n"),
            _ => format!("{line}\r\n"),
        })
        .collect();
    assert_eq!(corners(&read("a.obj", continued.as_bytes())), pyramid());
    assert_eq!(corners(&read("a.obj", format!("\u{feff}{text}").as_bytes())), pyramid());
    // An unused normal of an old C library, and colours behind a position.
    let with = "v 0 0 0 1 0 0\nv 1. 0 0 1 0 0\nv 0 +1 0 1 0 0\nvn -1.#IND 0 1\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 2\n";
    assert_eq!(read("a.obj", with.as_bytes()).triangles.len(), 2);
    let said = remarks("a.obj", with.as_bytes());
    assert!(
        said.iter().any(|s| s.contains("vertex colours")) && said.iter().any(|s| s.contains("2 materials")),
        "{said:?}"
    );
}

#[test]
fn an_ascii_ply_may_have_blank_lines_and_numbers_of_any_spelling() {
    let plain = read("a.ply", &ell_ply(1, "6 3 4 5 0 1 2\n"));
    let text = String::from_utf8(ell_ply(1, "6 3 4 5 0 1 2\n")).unwrap();
    let spaced = text.replace("end_header\n", "end_header\n\n").replace("0 2 0\n", "\n0 2 0\n \n");
    assert_eq!(read("a.ply", spaced.as_bytes()), plain);
    let spelt = text.replace("\n0 0 0\n", "\n.0 -.0 0.\n").replace("2 1 0\n", "2.D0 +1e0 0\n");
    assert_eq!(read("a.ply", spelt.as_bytes()), plain);
    assert_eq!(read("a.ply", format!("\u{feff}{text}").as_bytes()), plain);
    assert_eq!(read("a.ply", text.replace("6 3 4 5", "6 3 4\n5").as_bytes()), plain, "a face may go on");
    let more = mesh::read(&files(&[("a.ply", text.replace("2 1 0\n", "2 1 0 7\n").as_bytes())]), "a.ply").unwrap_err();
    assert!(more.to_string().contains("Line 12: has 4 values, 3 are announced"), "{more}");
}

#[test]
fn doubles_far_from_their_origin_are_refused() {
    let text = String::from_utf8(ell_ply(1, "6 3 4 5 0 1 2\n")).unwrap();
    let far: String = text.replace(
        ELL,
        &ELL.lines().map(|line| format!("46497{}\n", line.replacen(' ', "76.5 46497", 1))).collect::<String>(),
    );
    let error = mesh::read(&files(&[("a.ply", far.as_bytes())]), "a.ply").unwrap_err().to_string();
    assert!(error.contains("m from its origin") && error.contains("object_to_world"), "{error}");
}

#[test]
fn an_stl_may_be_in_capitals_and_have_several_solids() {
    let text = String::from_utf8(stl_ascii()).unwrap();
    assert_eq!(corners(&read("a.stl", text.to_uppercase().as_bytes())), pyramid());
    assert_eq!(corners(&read("a.stl", format!("\u{feff}\n{text}").as_bytes())), pyramid());
    let nan = text.replace("normal 0 0 0", "normal -1.#IND nan 0");
    assert_eq!(corners(&read("a.stl", nan.as_bytes())), pyramid());
    let twice = format!("{text}{}", text.replace("3e-1", "4e-1"));
    assert_eq!(read("a.stl", twice.as_bytes()).triangles.len(), 12);
    assert!(remarks("a.stl", twice.as_bytes())[0].contains("2 solids"));
}

#[test]
fn normals_and_vertices_that_nothing_uses_do_not_matter() {
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                  property float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
                  property list uchar int vertex_indices\nend_header\n";
    let mesh = read(
        "a.ply",
        format!("{header}0 0 0 0 0 1\nnan 0 0 -1.#IND 0 0\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 2 3\n").as_bytes(),
    );
    assert_eq!((mesh.positions.len(), mesh.triangles[0]), (3, [0, 1, 2]));
    // For those who need no normals, a bad one of a used vertex does not matter either.
    let zero = format!("{header}0 0 0 0 0 0\n9 9 9 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 2 3\n");
    let capture = files(&[("a.ply", zero.as_bytes())]);
    assert!(mesh::read(&capture, "a.ply").is_err());
    assert_eq!(mesh::read_shape(&capture, "a.ply").unwrap().normals, None);
}

#[test]
fn a_gltf_may_hold_edges_parts_without_normals_and_looks() {
    let whole = corners(&read("a.glb", &Gltf::default().glb()));
    let with = |primitives: &str| Gltf { primitives: primitives.into(), ..Gltf::default() }.glb();
    let edges = r#"[{"attributes":{"POSITION":0},"indices":3},{"attributes":{"POSITION":0},"indices":3,"mode":1}]"#;
    assert_eq!(corners(&read("a.glb", &with(edges))), whole);

    let (plain, smooth) =
        (r#"{"attributes":{"POSITION":0},"indices":3}"#, r#"{"attributes":{"POSITION":0,"NORMAL":1},"indices":3}"#);
    for (first, second, flat) in [(plain, smooth, 0..18), (smooth, plain, 5..23)] {
        let mesh = read("a.glb", &with(&format!("[{first},{second}]")));
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (23, 12));
        assert_eq!(corners(&mesh), [whole.clone(), whole.clone()].concat());
        let normals = mesh.normals.as_ref().unwrap();
        // The flat ones are the faces' own: the first two faces are the base, which looks down.
        for index in flat.clone().take(6) {
            assert!(normals[index][2] < -0.99, "{:?}", normals[index]);
        }
        assert!(remarks("a.glb", &with(&format!("[{first},{second}]")))[0].contains("2 parts"));
    }
    let needs = |name: &str| Gltf { extra: format!(r#""extensionsRequired":["{name}"],"#), ..Gltf::default() }.glb();
    assert_eq!(corners(&read("a.glb", &needs("KHR_texture_transform"))), whole);
    assert!(mesh::read(&files(&[("a.glb", &needs("EXT_mesh_gpu_instancing"))]), "a.glb").is_err());
    let marked = [b"\xef\xbb\xbf".to_vec(), Gltf::default().embedded()].concat();
    assert_eq!(corners(&read("a.gltf", &marked)), whole);
}
