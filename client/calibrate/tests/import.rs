//! Imported cameras see known points where their sources say they do.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_calibrate::{Draft, Imported, View, bop, colmap, project, transforms};
use gonio_scene::Capture;
use nalgebra::{Matrix4, Vector3, Vector4};

/// Where `view` sees a point of the world, pixels.
fn seen(view: &View, point: [f64; 3]) -> [f64; 2] {
    let m = Matrix4::from_fn(|i, j| view.camera_to_world[i][j]);
    let p = m.try_inverse().unwrap() * Vector4::new(point[0], point[1], point[2], 1.0);
    project(&view.camera, &Vector3::new(p.x, p.y, p.z)).unwrap()
}

fn near(a: [f64; 2], b: [f64; 2]) {
    assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9, "{a:?} {b:?}");
}

fn reads_back(imported: &Imported) {
    let draft = Draft::new("x", &imported.views, &[], Vec::new());
    let text = draft.to_toml().unwrap();
    assert!(text.contains("# GUESS:"));
    assert_eq!(Capture::parse(&text).unwrap(), draft.capture);
}

#[test]
fn colmap_maps_the_world_to_the_camera() {
    // A quarter turn about z: world x becomes camera y.
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let images = format!("# list\n7 {h} 0 0 {h} 0.1 0.2 2 3 a b.jpg\n\n8 1 0 0 0 0 0 1 3 c.jpg\n1 2 -1\n");
    let cameras = "# list\n3 OPENCV 640 480 500 510 320 240 0 0 0 0\n";
    let imported = colmap(cameras, &images).unwrap();
    assert_eq!(imported.views.len(), 2);
    assert_eq!(imported.views[0].file, "a b.jpg");
    // (1, 0, 0) -> (0.1, 1.2, 2).
    near(seen(&imported.views[0], [1.0, 0.0, 0.0]), [320.0 + 500.0 * 0.05, 240.0 + 510.0 * 0.6]);
    reads_back(&imported);
    for (cameras, images, says) in [
        ("1 OPENCV_FISHEYE 640 480 1 1 1 1 0 0 0 0\n", "", "cameras.txt: line 1: is the model OPENCV_FISHEYE"),
        (cameras, "7 1 0 0 0 0 0 1 9 a.jpg\n\n", "images.txt: line 1: names camera 9"),
        (cameras, "7 1 1 0 0 0 0 1 3 a.jpg\n\n", "images.txt: line 1: has a quaternion"),
        (cameras, "# none\n", "images.txt: lists no image"),
    ] {
        let error = colmap(cameras, images).unwrap_err().to_string();
        assert!(error.starts_with(says), "{error}");
    }
}

#[test]
fn transforms_look_along_minus_z_with_y_up() {
    let text = r#"{"camera_angle_x": 1.5707963267948966, "frames": [{"file_path": "./r_0",
        "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}]}"#;
    let locate = |name: &str| Ok((format!("{name}.png"), (200, 100)));
    let imported = transforms("t.json", text, &locate).unwrap();
    // f = 100; a point to the right and above, 4 m ahead: right of the centre and above it.
    near(seen(&imported.views[0], [1.0, 0.5, 0.0]), [100.0 + 25.0, 50.0 - 12.5]);
    reads_back(&imported);
    for (text, says) in [
        ("{", "t.json: is no JSON"),
        ("{}", "t.json: frames: is missing"),
        (r#"{"frames": [{"file_path": "a"}]}"#, "t.json: frames[0].transform_matrix: is missing"),
    ] {
        let error = transforms("t.json", text, &locate).unwrap_err().to_string();
        assert!(error.starts_with(says), "{error}");
    }
}

#[test]
fn bop_has_millimetres_and_whole_pixel_centres() {
    let camera = r#"{"3": {"cam_K": [500,0,320,0,500,240,0,0,1]}}"#;
    let truth = r#"{"3": [{"cam_R_m2c": [0,-1,0,1,0,0,0,0,1], "cam_t_m2c": [100,0,1000], "obj_id": 5}]}"#;
    let locate = |number: u32| Ok((format!("{number:06}.png"), (640, 480)));
    let imported = bop(camera, Some(truth), &locate).unwrap();
    assert_eq!(imported.views[0].file, "000003.png");
    // 50 mm along the object's x is camera y: (0.1, 0.05, 1) m.
    near(seen(&imported.views[0], [0.05, 0.0, 0.0]), [320.5 + 50.0, 240.5 + 25.0]);
    let (id, placed) = imported.objects[0];
    assert!(id == 5 && (placed[0][0] - 1e-3).abs() < 1e-12 && placed[0][3].abs() < 1e-12, "{placed:?}");
    reads_back(&imported);
    let error = bop(camera, None, &locate).unwrap_err().to_string();
    assert!(error.starts_with("scene_gt.json: 3: is missing"), "{error}");
    let error = bop("{\"3\": {}}", Some(truth), &locate).unwrap_err().to_string();
    assert!(error.starts_with("scene_camera.json: 3.cam_K: is missing"), "{error}");
}
