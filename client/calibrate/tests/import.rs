//! Imported cameras see known points where their sources say they do.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_calibrate::{Draft, Imported, View, bop, colmap, colmap_binary, project, transforms};
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

/// The binary form of a camera `3` of model `model` and of an image `7` with `points` points.
fn binary(model: u32, parameters: &[f64], points: u64) -> (Vec<u8>, Vec<u8>) {
    let mut cameras = [&1_u64.to_le_bytes()[..], &3_u32.to_le_bytes(), &model.to_le_bytes()].concat();
    cameras.extend([640_u64, 480].iter().flat_map(|side| side.to_le_bytes()));
    cameras.extend(parameters.iter().flat_map(|number| number.to_le_bytes()));
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let mut images = [&1_u64.to_le_bytes()[..], &7_u32.to_le_bytes()].concat();
    images.extend([h, 0.0, 0.0, h, 0.1, 0.2, 2.0].iter().flat_map(|number| number.to_le_bytes()));
    images.extend([&3_u32.to_le_bytes()[..], b"a b.jpg\0", &points.to_le_bytes()].concat());
    images.extend(vec![7; 24 * points as usize]);
    (cameras, images)
}

const OPENCV: [f64; 8] = [500.0, 510.0, 320.0, 240.0, 0.1, -0.02, 0.001, 0.002];

#[test]
fn colmaps_binary_model_says_what_its_text_says() {
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let (cameras, images) = binary(4, &OPENCV, 2);
    let imported = colmap_binary(&cameras, &images).unwrap();
    let text = "3 OPENCV 640 480 500 510 320 240 0.1 -0.02 0.001 0.002\n";
    let same = colmap(text, &format!("7 {h} 0 0 {h} 0.1 0.2 2 3 a b.jpg\n1 2 3 4 5 6\n")).unwrap();
    assert_eq!(imported.views, same.views);
    reads_back(&imported);
    for (model, parameters) in [(0, 3), (1, 4), (2, 4), (3, 5)] {
        let (cameras, images) = binary(model, &OPENCV[..parameters], 0);
        assert_eq!(colmap_binary(&cameras, &images).unwrap().views.len(), 1);
    }
}

#[test]
fn broken_binary_models_are_refused_without_room_for_what_they_claim() {
    let (cameras, images) = binary(4, &OPENCV, 2);
    let refusal = |cameras: &[u8], images: &[u8]| colmap_binary(cameras, images).unwrap_err().to_string();
    for length in 0..cameras.len() {
        assert!(refusal(&cameras[..length], &images).starts_with("cameras.bin: "));
    }
    for length in 0..images.len() {
        assert!(refusal(&cameras, &images[..length]).starts_with("images.bin: "));
    }
    assert!(refusal(&[&cameras[..], &[0]].concat(), &images).starts_with("cameras.bin: has 1 bytes more"));
    assert!(refusal(&cameras, &[&images[..], &[0]].concat()).starts_with("images.bin: has 1 bytes more"));
    let changed = |bytes: &[u8], at: usize, to: &[u8]| [&bytes[..at], to, &bytes[at + to.len()..]].concat();
    let most = u64::MAX.to_le_bytes();
    let points = images.len() - 48 - 8;
    for (cameras, images, says) in [
        (changed(&cameras, 0, &most), images.clone(), "cameras.bin: camera 1: ends before its number"),
        (cameras.clone(), changed(&images, 0, &most), "images.bin: image 1: ends before its number"),
        (cameras.clone(), changed(&images, points, &most), "images.bin: image 0: ends before its points"),
        (
            cameras.clone(),
            changed(&images, points, &(u64::MAX / 24 + 1).to_le_bytes()),
            "images.bin: image 0: ends before",
        ),
        (changed(&cameras, 12, &[99]), images.clone(), "cameras.bin: camera 0: is of model 99"),
        (changed(&cameras, 16, &most), images.clone(), "cameras.bin: camera 0: is 18446744073709551615 pixels"),
        (changed(&cameras, 16, &[0; 8]), images.clone(), "cameras.bin: camera 0: is 0 pixels"),
        (changed(&cameras, 32, &f64::NAN.to_le_bytes()), images.clone(), "cameras.bin: camera 0: has a parameter"),
        (changed(&cameras, 8, &[9]), images.clone(), "images.bin: image 0: has camera 3, not in cameras.bin"),
        (cameras.clone(), changed(&images, 12, &f64::INFINITY.to_le_bytes()), "images.bin: image 0: has a pose"),
        (cameras.clone(), changed(&images, 12, &[0; 8]), "images.bin: image 0: has a quaternion"),
        (cameras.clone(), changed(&images, 72, &[0xff]), "images.bin: image 0: has no name"),
        (cameras.clone(), 0_u64.to_le_bytes().to_vec(), "images.bin: lists no image"),
    ] {
        let error = refusal(&cameras, &images);
        assert!(error.starts_with(says), "{says}: {error}");
    }
    let (fisheye, images) = binary(5, &OPENCV, 0);
    assert!(refusal(&fisheye, &images).starts_with("cameras.bin: camera 0: is the model OPENCV_FISHEYE with 8"));
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
