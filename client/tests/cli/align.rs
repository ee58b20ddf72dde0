//! `gonio align`: a part that is placed wrongly finds back, by clicked points and by outlines.

use crate::fixture::{TRUTH, capture, capture_file, edit, json, refused, scene, succeeds};
use gonio_scene::Capture;
use gonio_scene::mesh::{Mesh, write_ply};
use std::path::Path;

/// Corners of a skew tetrahedron, metres: no turn maps it to itself.
const CORNERS: [[f32; 3]; 4] = [[-0.04, -0.03, -0.02], [0.05, -0.02, -0.02], [-0.02, 0.05, -0.01], [0.0, 0.0, 0.04]];

/// Where the object stands, mesh coordinates to the world.
fn placement(at: &Path) -> [[f64; 4]; 4] {
    capture(at).objects[0].placement()
}

/// The largest distance between the corners at two places, metres.
fn apart(a: &[[f64; 4]; 4], b: &[[f64; 4]; 4]) -> f64 {
    let corner = |m: &[[f64; 4]; 4], p: [f32; 3]| {
        [0, 1, 2].map(|i| m[i][3] + (0..3).map(|k| m[i][k] * f64::from(p[k])).sum::<f64>())
    };
    let distance = |p: [f32; 3]| {
        let (x, y) = (corner(a, p), corner(b, p));
        (0..3).map(|k| (x[k] - y[k]).powi(2)).sum::<f64>().sqrt()
    };
    CORNERS.into_iter().map(distance).fold(0.0, f64::max)
}

/// A line of the file of points for each corner in each of two photos, `off` pixels wrong.
fn points(capture: &Capture, off: f64) -> String {
    let mut text = "photo,x,y,mesh_x,mesh_y,mesh_z\n".to_owned();
    let place = capture.objects[0].placement();
    for (number, photo) in capture.photos[..2].iter().enumerate() {
        let (pose, camera) = (photo.camera_to_world, capture.camera_of(photo));
        for (index, corner) in CORNERS.iter().enumerate() {
            let world =
                [0, 1, 2].map(|i| place[i][3] + (0..3).map(|k| place[i][k] * f64::from(corner[k])).sum::<f64>());
            let seen = [0, 1, 2].map(|k| (0..3).map(|i| pose[i][k] * (world[i] - pose[i][3])).sum::<f64>());
            // Wrong to all sides.
            let (sin, cos) = (2.4 * (index + 4 * number) as f64).sin_cos();
            let x = camera.fx * seen[0] / seen[2] + camera.cx + off * cos;
            let y = camera.fy * seen[1] / seen[2] + camera.cy + off * sin;
            let [a, b, c] = corner;
            text += &format!("{},{x:.2},{y:.2},{a},{b},{c}\n", photo.name());
        }
    }
    text
}

#[test]
fn a_part_finds_its_place_by_points_and_by_outlines() {
    let top = scene(TRUTH);
    let at = top.path();
    for (from, to) in [("width = 32", "width = 320"), ("height = 24", "height = 240"), ("= 48.0", "= 480.0")] {
        edit(&capture_file(&top), from, to);
    }
    edit(&capture_file(&top), "cx = 16.0\ncy = 12.0", "cx = 160.0\ncy = 120.0");
    let tetrahedron = Mesh {
        positions: CORNERS.to_vec(),
        normals: None,
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        degenerate: 0,
    };
    std::fs::write(at.join("capture/ball.ply"), write_ply(&tetrahedron)).unwrap();
    let truth = placement(&at.join("capture"));
    std::fs::write(at.join("points.csv"), points(&capture(&at.join("capture")), 1.0)).unwrap();
    // Masks as people draw them, two pixels inside.
    succeeds(at, &["mask", "capture", "--objects", "ball", "--grow", "-2", "--out", "capture/masks"]);
    for photo in 0..4 {
        let file = format!("file = \"photos/0{photo}.exr\"\n");
        edit(&capture_file(&top), &file, &format!("{file}mask = \"masks/0{photo}.png\"\n"));
    }
    // Turned by 100 degrees about an odd axis, and elsewhere: points alone know better.
    let lost = "rotation = [1.2, -0.8, 1.0]\ntranslation = [0.05, 0.02, -0.03]\n";
    edit(&capture_file(&top), "material = \"shell\"\n", &format!("material = \"shell\"\n{lost}"));
    assert!(apart(&placement(&at.join("capture")), &truth) > 0.05);
    let points = ["align", "capture", "--object", "ball", "--points", "points.csv", "--json"];
    let told = json(&succeeds(at, &[&points[..], &["--no-outlines", "--out", "clicked"]].concat()));
    let off = apart(&placement(&at.join("clicked")), &truth);
    // A pixel is 0.8 mm there; eight points that are a pixel off leave about a half of that.
    assert!(off < 1e-3, "{off} {told}");
    let error = told["points"]["translation_error"].as_f64().unwrap();
    assert!((1e-4..1.5e-3).contains(&error), "{told}");
    let told = json(&succeeds(at, &[&points[..], &["--out", "aligned"]].concat()));
    let off = apart(&placement(&at.join("aligned")), &truth);
    assert!(off < 3e-4, "{off} {told}");
    assert_eq!(told["masks"], 3, "the photo that judges is not looked at");
    let margin = told["margin"].as_f64().unwrap();
    assert!((-2.6..-1.4).contains(&margin), "{told}");
    // From near its place it needs no points.
    let near = "rotation = [0.05, -0.03, 0.04]\ntranslation = [0.002, -0.003, 0.002]\n";
    edit(&capture_file(&top), lost, near);
    succeeds(at, &["align", "capture", "--object", "ball", "--out", "outlined"]);
    let off = apart(&placement(&at.join("outlined")), &truth);
    assert!(off < 3e-4, "{off}");

    let bad = |text: &str, says: &[&str]| {
        std::fs::write(at.join("bad.csv"), text).unwrap();
        refused(at, &["align", "capture", "--object", "ball", "--points", "bad.csv", "--out", "x"], says);
    };
    let head = "photo,x,y,mesh_x,mesh_y,mesh_z\n";
    bad("a,b\n1,2\n", &["bad.csv: point 1", "photo,x,y"]);
    bad(&format!("{head}07,1,2,0,0,0\n"), &["bad.csv: point 1", "\"07\"", "the photos are: 00"]);
    bad(&format!("{head}00,999,2,0,0,0\n"), &["bad.csv: point 1", "outside of its photo"]);
    bad(&format!("{head}00,1,2,0,0,0\n"), &["1 clicks do not determine a place"]);
    let line: String = (0..4).map(|k| format!("00,{},20,{},0,0\n", 20 + 9 * k, 0.01 * f64::from(k))).collect();
    bad(&format!("{head}{line}"), &["bad.csv: ", "click"]);
    refused(at, &["align", "capture", "--out", "x"], &["--object", "several objects"]);
}
