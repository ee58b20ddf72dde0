//! `gonio check`.

use crate::fixture::{ball, capture_file, edit, gonio, gray, json, succeeds};
use gonio_scene::mesh::{Mesh, write_ply};
use serde_json::Value;

#[test]
fn summarises_what_is_there() {
    let top = gray();
    let result = json(&succeeds(top.path(), &["check", "capture", "--json", "--names"]));
    assert_eq!(result["warnings"], Value::Array(vec![]), "{result:#}");
    let photos = result["photos"].as_array().unwrap();
    assert_eq!(photos.len(), 4);
    assert_eq!((&photos[3]["role"], &photos[0]["counted"]), (&"held-out".into(), &(32 * 24).into()));
    assert_eq!(photos[0]["mean"][0], 0.25);
    assert_eq!((&result["objects"][0]["name"], &result["objects"][0]["photos"]), (&"ball".into(), &4.into()));
    assert_eq!(result["lights"][0]["kind"], "point");
    assert_eq!(result["parameters"].as_array().unwrap().len(), 5);
    let names = result["numbers"].as_array().unwrap();
    assert!(names.iter().any(|n| n["name"] == "material.shell.ior" && n["value"] == 1.5 && n["max"] == 4.0));
    let text = succeeds(top.path(), &["check", "capture/capture.toml"]);
    assert!(text.contains("ball") && text.ends_with("valid, with 0 warnings\n"), "{text}");
}

#[test]
fn tells_all_errors_at_once() {
    let top = gray();
    let root = top.path().join("capture");
    std::fs::remove_file(root.join("ball.ply")).unwrap();
    std::fs::write(root.join("board.ply"), "ply\n").unwrap();
    std::fs::write(root.join("photos/01.exr"), "x").unwrap();
    std::fs::remove_file(root.join("photos/02.exr")).unwrap();
    let output = gonio(top.path(), &["check", "capture"]);
    assert_eq!(output.status.code(), Some(2));
    let stderr = String::from_utf8(output.stderr).unwrap();
    for file in ["ball.ply", "board.ply", "photos/01.exr", "photos/02.exr"] {
        assert_eq!(
            stderr.lines().filter(|l| l.starts_with(&format!("error: {file}: "))).count(),
            1,
            "{file}: {stderr}"
        );
    }
    let result = gonio(top.path(), &["check", "capture", "--json"]);
    assert_eq!(result.status.code(), Some(2));
    let result = json(&String::from_utf8(result.stdout).unwrap());
    assert_eq!(result["valid"], false);
    assert_eq!(result["errors"].as_array().unwrap().len(), 4);
    assert_eq!(result["photos"].as_array().unwrap().len(), 2);
}

/// An edit of the capture, and a part of the warning that it must bring.
const MISTAKES: [(&str, &str, &str); 7] = [
    (
        "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
        "[[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]",
        "turns its back",
    ),
    ("[0, 0, 1, 0.05]", "[0, 0, 1, 50.0]", "no photo has it in view"),
    ("[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.05]", "[[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.05]", "mirrors"),
    ("file = \"photos/01.exr\"", "file = \"photos/01.exr\"\nexposure = 1e-4", "is the exposure right"),
    ("file = \"photos/01.exr\"", "file = \"photos/01.exr\"\nlights = []", "no light is on"),
    ("role = \"fit\"", "role = \"held-out\"", "every photo is held out"),
    ("roughness = 0.5", "roughness = 0.0", "at its bound 0"),
];

#[test]
fn warns_of_likely_mistakes() {
    for (from, to, warning) in MISTAKES {
        let top = gray();
        edit(&capture_file(&top), from, to);
        let text = succeeds(top.path(), &["check", "capture"]);
        assert!(text.lines().any(|line| line.starts_with("warning: ") && line.contains(warning)), "{warning}: {text}");
    }
}

/// Writes `change` of the ball's mesh, and gives the warnings of a check.
fn warnings_of(change: impl FnOnce(&mut Mesh)) -> String {
    let top = gray();
    let mut mesh = ball();
    change(&mut mesh);
    std::fs::write(top.path().join("capture/ball.ply"), write_ply(&mesh)).unwrap();
    succeeds(top.path(), &["check", "capture"])
}

#[test]
fn warns_of_faces_that_contradict_each_other() {
    let torn = warnings_of(|mesh| mesh.triangles.iter_mut().step_by(2).for_each(|triangle| triangle.swap(1, 2)));
    assert!(torn.contains("one face is wound against the other"), "{torn}");
    let doubled = warnings_of(|mesh| {
        let backs: Vec<_> = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        mesh.triangles.extend(backs);
    });
    assert!(doubled.contains("lie on each other, wound both ways"), "{doubled}");
    assert!(warnings_of(|_| ()).ends_with("valid, with 0 warnings\n"));
}

#[test]
fn a_pose_that_mirrors_keeps_the_outside_outside_as_in_the_renderer() {
    let mirrored = |turned: bool| {
        let top = gray();
        let mut mesh = ball();
        mesh.normals = None;
        if turned {
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        std::fs::write(top.path().join("capture/ball.ply"), write_ply(&mesh)).unwrap();
        edit(&capture_file(&top), BALL, &BALL.replace("[[1, 0", "[[-1, 0"));
        succeeds(top.path(), &["check", "capture"])
    };
    let (right, wrong) = (mirrored(false), mirrored(true));
    assert!(right.contains("mirrors the mesh") && !right.contains("point inward"), "{right}");
    assert!(wrong.contains("point inward: flip their winding in the file"), "{wrong}");
}

/// The pose of the ball in the capture.
const BALL: &str = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.05]";

#[test]
fn warns_of_a_lamp_and_of_cameras_inside_of_a_part() {
    // A ball in millimetres, read as metres, holds everything.
    let text = warnings_of(|mesh| mesh.positions.iter_mut().flatten().for_each(|value| *value *= 1000.0));
    assert!(text.contains("stands inside of object ball, which is "), "{text}");
    let top = gray();
    let camera = "frame = \"camera\"\nposition = [0.05, 0.0, 0.0]";
    edit(&capture_file(&top), camera, "position = [0.0, 0.0, 0.06]");
    let text = succeeds(top.path(), &["check", "capture"]);
    assert!(text.contains("light.led.position: lies inside of object ball"), "{text}");
}

#[test]
fn warns_of_a_jpeg_whose_response_is_linear_and_before_a_fit_too() {
    let top = gray();
    let (width, height) = crate::fixture::SIZE;
    let values = vec![128_u8; (width * height * 3) as usize];
    image::save_buffer(
        top.path().join("capture/photos/01.jpg"),
        &values,
        width,
        height,
        image::ExtendedColorType::Rgb8,
    )
    .unwrap();
    edit(&capture_file(&top), "photos/01.exr", "photos/01.jpg");
    let text = succeeds(top.path(), &["check", "capture"]);
    assert!(text.contains("photos/01.jpg: is a JPEG, whose values have a display's curve"), "{text}");
    // Refused for its options, after the warnings.
    let output = gonio(top.path(), &["fit", "capture", "--out", "capture"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("warning: photos/01.jpg: is a JPEG"), "{stderr}");
}
