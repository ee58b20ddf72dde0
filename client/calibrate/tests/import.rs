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
        // Without the points' lines, every second image would be taken for the points of the one before.
        (
            cameras,
            "7 1 0 0 0 0 0 1 3 a.jpg\n8 1 0 0 0 0 0 1 3 b.jpg\n",
            "images.txt: line 2: is no list of an image's points",
        ),
        (cameras, "7 1 0 0 0 0 0 1 3 a.jpg\n1 2\n", "images.txt: line 2: is no list"),
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

fn frames(text: &str) -> String {
    let pose = "\"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]";
    format!("{{{}}}", text.replace("POSE", pose))
}

#[test]
fn a_frames_keys_are_read_as_groups() {
    let text = frames(
        r#""fl_x": 60, "fl_y": 61, "k1": 0.1, "k2": 0.2, "frames": [
        {"file_path": "a", "camera_angle_x": 0.9, POSE},
        {"file_path": "b", "fl_x": 50, "k1": -0.1, POSE},
        {"file_path": "c", POSE}]"#,
    );
    let locate = |name: &str| Ok((format!("{name}.png"), (64, 48)));
    let views = transforms("t.json", &text, &locate).unwrap().views;
    let found: Vec<_> = views.iter().map(|view| (view.camera.fx, view.camera.fy, view.camera.distortion)).collect();
    // An angle of a frame goes before a focal length of the file: 32 / tan(0.45).
    let angle = 32.0 / libm::tan(0.45);
    assert!((found[0].0 - angle).abs() < 1e-9 && (found[0].1 - angle).abs() < 1e-9, "{found:?}");
    assert_eq!(found[1], (50.0, 50.0, [-0.1, 0.0, 0.0, 0.0, 0.0]));
    assert_eq!(found[2], (60.0, 61.0, [0.1, 0.2, 0.0, 0.0, 0.0]));
    for (keys, says) in [
        (r#""is_fisheye": true"#, "t.json: frames[0].camera_model: is a camera that has no equal"),
        (r#""camera_model": "OPENCV_FISHEYE", "k1": 0.1"#, "t.json: frames[0].camera_model: "),
        (r#""k6": 0.01"#, "t.json: frames[0].camera_model: "),
        (r#""camera_angle_x": NaN"#, "t.json: frames[0].camera_angle_x: is no number"),
    ] {
        let text = frames(&format!(r#""fl_x": 60, "frames": [{{"file_path": "a", {keys}, POSE}}]"#));
        let error = transforms("t.json", &text, &locate).unwrap_err().to_string();
        assert!(error.starts_with(says), "{error}");
    }
}

#[test]
fn a_size_that_is_not_the_images_is_a_scale_or_refused() {
    let text =
        frames(r#""fl_x": 60, "fl_y": 60, "w": 48, "h": 64, "sharp": NaN, "frames": [{"file_path": "a", POSE}]"#);
    let of = |size: (u32, u32)| transforms("t.json", &text, &move |name: &str| Ok((name.to_owned(), size)));
    assert_eq!(of((24, 32)).unwrap().views[0].camera.fx, 30.0);
    // A side of an odd number of pixels is rounded.
    assert!(of((23, 31)).is_ok());
    for size in [(64, 48), (48, 60), (40, 64)] {
        let error = of(size).unwrap_err().to_string();
        assert!(
            error.starts_with("t.json: w: is 48 x 64, its image ") && error.contains("cropped or turned"),
            "{error}"
        );
    }
}

#[test]
fn photos_of_equal_names_are_told_apart_by_their_folders() {
    let view = |file: &str| View {
        file: file.to_owned(),
        camera: gonio_scene::capture::Camera { width: 4, height: 3, fx: 4.0, fy: 4.0, ..Default::default() },
        camera_to_world: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
    };
    let names = |files: &[&str]| {
        let views: Vec<View> = files.iter().map(|file| view(file)).collect();
        let text = Draft::new("x", &views, &[], Vec::new()).to_toml().unwrap();
        let capture = Capture::parse(&text).unwrap();
        capture.photos.iter().map(|photo| photo.name().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(names(&["../a/1.png", "../b/1.png", "../b/2.png"]), ["a-1", "b-1", "2"]);
    assert_eq!(names(&["x/a/1.png", "y/a/1.png"]), ["x-a-1", "y-a-1"]);
    assert_eq!(names(&["a/1.png", "a/1.jpg"]), ["1-png", "1-jpg"]);
    // A name that is taken already: the other photos must not get it.
    assert_eq!(names(&["a/1.png", "b/1.png", "a-1.png"]).len(), 3);
}

#[test]
fn bop_without_a_world_takes_one_object_by_its_number() {
    let cameras = r#"{"0": {"cam_K": [500,0,320,0,500,240,0,0,1]}, "1": {"cam_K": [500,0,320,0,500,240,0,0,1]}}"#;
    let pose =
        |id: u32, x: f64| format!(r#"{{"obj_id": {id}, "cam_R_m2c": [1,0,0,0,1,0,0,0,1], "cam_t_m2c": [{x},0,500]}}"#);
    // Object 2 lies 100 mm to the right of object 1; the second camera 30 mm to the left of the first.
    let truth = |second: &str| format!(r#"{{"0": [{}, {}], "1": [{second}]}}"#, pose(1, 0.0), pose(2, 100.0));
    let locate = |number: u32| Ok((format!("{number}.png"), (640, 480)));
    let read = |second: &str| bop(cameras, Some(&truth(second)), &locate);
    for second in [format!("{}, {}", pose(1, 30.0), pose(2, 130.0)), format!("{}, {}", pose(2, 130.0), pose(1, 30.0))] {
        let imported = read(&second).unwrap();
        let x: Vec<f64> = imported.views.iter().map(|view| view.camera_to_world[0][3]).collect();
        assert!((x[1] - x[0] + 0.03).abs() < 1e-12, "{x:?}");
        assert!((imported.objects[1].1[0][3] - imported.objects[0].1[0][3] - 0.1).abs() < 1e-12);
    }
    // Only object 2 is in both.
    let shared = read(&pose(2, 130.0)).unwrap();
    assert!((shared.views[1].camera_to_world[0][3] - shared.views[0].camera_to_world[0][3] + 0.03).abs() < 1e-12);
    for second in [pose(3, 0.0), format!("{0}, {0}", pose(1, 0.0))] {
        let error = read(&second).unwrap_err().to_string();
        assert!(error.starts_with("scene_gt.json: 1: shows object 1 not once"), "{error}");
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
