//! `gonio import`: cameras that others estimated.

use crate::fixture::{capture, gray_png, json, refused, succeeds};
use std::path::Path;

/// COLMAP's model of one camera and two images, as text and in its binary form.
fn models(at: &Path) {
    std::fs::create_dir_all(at.join("images")).unwrap();
    for name in ["a b.png", "c.png"] {
        gray_png(&at.join("images").join(name), 32, 24);
    }
    let (text, binary) = (at.join("sparse/text"), at.join("sparse/0"));
    std::fs::create_dir_all(&text).unwrap();
    std::fs::create_dir_all(&binary).unwrap();
    std::fs::write(text.join("cameras.txt"), "# cameras\n3 OPENCV 32 24 50 51 16 12 0.1 0 0 0\n").unwrap();
    std::fs::write(text.join("images.txt"), "7 0.6 0 0 0.8 0.1 0.2 2 3 a b.png\n\n8 1 0 0 0 0 0 1 3 c.png\n1 2 -1\n")
        .unwrap();
    let mut cameras =
        [1_u64.to_le_bytes().to_vec(), 3_u32.to_le_bytes().to_vec(), 4_u32.to_le_bytes().to_vec()].concat();
    cameras.extend([32_u64, 24].iter().flat_map(|side| side.to_le_bytes()));
    cameras.extend([50.0_f64, 51.0, 16.0, 12.0, 0.1, 0.0, 0.0, 0.0].iter().flat_map(|number| number.to_le_bytes()));
    std::fs::write(binary.join("cameras.bin"), cameras).unwrap();
    let mut images = 2_u64.to_le_bytes().to_vec();
    for (number, pose, name, points) in [
        (7_u32, [0.6_f64, 0.0, 0.0, 0.8, 0.1, 0.2, 2.0], "a b.png", 0_u64),
        (8, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], "c.png", 1),
    ] {
        images.extend(number.to_le_bytes());
        images.extend(pose.iter().flat_map(|number| number.to_le_bytes()));
        images.extend(3_u32.to_le_bytes());
        images.extend(name.bytes().chain([0]));
        images.extend(points.to_le_bytes());
        images.extend(vec![0; 24 * points as usize]);
    }
    std::fs::write(binary.join("images.bin"), images).unwrap();
}

#[test]
fn a_model_of_colmap_is_imported_from_text_and_from_its_binary_form_alike() {
    let top = tempfile::tempdir().unwrap();
    let at = top.path();
    models(at);
    let told = json(&succeeds(at, &["import", "colmap", "sparse/text", "--out", "t/capture.toml", "--json"]));
    assert_eq!(told["photos"], 2);
    succeeds(at, &["import", "colmap", "sparse/0", "--out", "b/capture.toml"]);
    let (text, binary) = (capture(&at.join("t")), capture(&at.join("b")));
    assert_eq!((&text.camera, &text.photos), (&binary.camera, &binary.photos));
    assert_eq!((text.photos[0].file.as_str(), text.camera.distortion[0]), ("../images/a b.png", 0.1));
    assert!((text.photos[1].camera_to_world[2][3] + 1.0).abs() < 1e-12);

    let import = |model: &'static str| ["import", "colmap", model, "--out", "x/capture.toml"];
    refused(at, &import("sparse"), &["cameras.txt: ", "cameras.bin and images.bin"]);
    std::fs::write(at.join("sparse/text/cameras.txt"), "3 OPENCV_FISHEYE 32 24 1 1 1 1 0 0 0 0\n").unwrap();
    refused(at, &import("sparse/text"), &["cameras.txt: line 1: is the model OPENCV_FISHEYE", "image_undistorter"]);
    let images = at.join("sparse/0/images.bin");
    let whole = std::fs::read(&images).unwrap();
    std::fs::write(&images, &whole[..whole.len() - 1]).unwrap();
    refused(at, &import("sparse/0"), &["images.bin: image 1: ends before its points do", "copy the file anew"]);
    std::fs::write(&images, [&u64::MAX.to_le_bytes(), &whole[8..]].concat()).unwrap();
    refused(at, &import("sparse/0"), &["images.bin: image 2: ends before its number"]);
    std::fs::remove_file(&images).unwrap();
    refused(at, &import("sparse/0"), &["images.bin: does not exist"]);
    std::fs::write(&images, &whole).unwrap();
    gray_png(&at.join("images/c.png"), 16, 12);
    refused(at, &import("sparse/0"), &["images/c.png: is 16 x 12, its camera in COLMAP's model 32 x 24", "--images"]);
    std::fs::remove_file(at.join("images/c.png")).unwrap();
    refused(at, &import("sparse/0"), &["c.png: is not in", "--images"]);
}

#[test]
fn transforms_and_scenes_of_bop_are_imported() {
    let top = tempfile::tempdir().unwrap();
    let at = top.path();
    gray_png(&at.join("r_0.png"), 40, 20);
    let identity = "[[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]";
    let good =
        format!(r#"{{"camera_angle_x": 0.9, "frames": [{{"file_path": "./r_0", "transform_matrix": {identity}}}]}}"#);
    std::fs::write(at.join("transforms.json"), &good).unwrap();
    succeeds(at, &["import", "transforms", "transforms.json", "--out", "t/capture.toml"]);
    let imported = capture(&at.join("t"));
    assert_eq!((imported.photos[0].file.as_str(), imported.camera.width), ("../r_0.png", 40));
    let import = ["import", "transforms", "transforms.json", "--out", "x/capture.toml"];
    for (text, says) in [
        ("{", "transforms.json: is no JSON"),
        ("{}", "transforms.json: frames: is missing"),
        (&good.replace("0.9", "\"wide\""), "transforms.json: "),
        (&good.replace("./r_0", "./r_9"), "r_9: frames[0].file_path: is not in"),
        (&good.replace(identity, "[[1,0,0,0]]"), "transforms.json: frames[0].transform_matrix: "),
    ] {
        std::fs::write(at.join("transforms.json"), text).unwrap();
        refused(at, &import, &[says]);
    }
    refused(
        at,
        &["import", "transforms", "none.json", "--out", "x/capture.toml"],
        &["none.json: does not exist", "transforms.json"],
    );

    let scene = at.join("test/000002");
    std::fs::create_dir_all(scene.join("rgb")).unwrap();
    gray_png(&scene.join("rgb/000003.png"), 40, 20);
    std::fs::create_dir(at.join("models")).unwrap();
    std::fs::write(at.join("models/obj_000005.ply"), "ply\n").unwrap();
    let camera = r#"{"3": {"cam_K": [50,0,20,0,50,10,0,0,1]}}"#;
    let truth = r#"{"3": [{"cam_R_m2c": [0,-1,0,1,0,0,0,0,1], "cam_t_m2c": [100,0,1000], "obj_id": 5}]}"#;
    std::fs::write(scene.join("scene_camera.json"), camera).unwrap();
    std::fs::write(scene.join("scene_gt.json"), truth).unwrap();
    let import =
        |out: &'static str, more: &[&'static str]| [&["import", "bop", "test/000002", "--out", out], more].concat();
    let told = json(&succeeds(at, &import("b/capture.toml", &["--json", "--models", "models"])));
    assert_eq!((&told["photos"], &told["objects"]), (&1.into(), &1.into()));
    assert_eq!(capture(&at.join("b")).objects[0].mesh, "../models/obj_000005.ply");
    refused(at, &import("x/capture.toml", &["--models", "rgb"]), &["obj_000005.ply: is not in rgb", "--models"]);
    std::fs::write(scene.join("scene_camera.json"), "{\"3\": {}}").unwrap();
    refused(at, &import("x/capture.toml", &[]), &["scene_camera.json: 3.cam_K: is missing"]);
    std::fs::write(scene.join("scene_camera.json"), camera.replace("\"3\"", "\"4\"")).unwrap();
    refused(at, &import("x/capture.toml", &[]), &["scene_gt.json: 4: is missing"]);
    refused(
        at,
        &["import", "bop", "nowhere", "--out", "x/capture.toml"],
        &["scene_camera.json: does not exist", "000002"],
    );
    refused(
        at,
        &["import", "colmap", "test", "--models", "models", "--out", "x/capture.toml"],
        &["--models: is for bop alone"],
    );
}

#[test]
fn rigs_backslashes_and_endings_in_capitals_are_found() {
    let top = tempfile::tempdir().unwrap();
    let at = top.path();
    for folder in ["images/cam0", "images/cam1"] {
        std::fs::create_dir_all(at.join(folder)).unwrap();
        gray_png(&at.join(folder).join("1.png"), 32, 24);
        std::fs::rename(at.join(folder).join("1.png"), at.join(folder).join("1.PNG")).unwrap();
    }
    std::fs::create_dir(at.join("model")).unwrap();
    std::fs::write(at.join("model/cameras.txt"), "1 PINHOLE 32 24 50 50 16 12\n").unwrap();
    std::fs::write(at.join("model/images.txt"), "1 1 0 0 0 0 0 1 1 cam0\\1.PNG\n\n2 1 0 0 0 0 0 1 1 cam1\\1.png\n\n")
        .unwrap();
    succeeds(at, &["import", "colmap", "model", "--out", "c/capture.toml"]);
    let photos = capture(&at.join("c")).photos;
    let found: Vec<_> = photos.iter().map(|photo| (photo.file.as_str(), photo.name())).collect();
    assert_eq!(found, [("../images/cam0/1.PNG", "cam0-1"), ("../images/cam1/1.PNG", "cam1-1")]);

    let pose = "\"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]";
    let frame = |path: &str| format!("{{\"file_path\": \"{path}\", {pose}}}");
    let text =
        format!("{{\"fl_x\": 50, \"frames\": [{}, {}]}}", frame("images/cam0/1"), frame("images\\\\cam1\\\\1.png"));
    std::fs::write(at.join("transforms.json"), text).unwrap();
    succeeds(at, &["import", "transforms", "transforms.json", "--out", "t/capture.toml"]);
    let names: Vec<_> = capture(&at.join("t")).photos.iter().map(|photo| photo.name().to_owned()).collect();
    assert_eq!(names, ["cam0-1", "cam1-1"]);
}
