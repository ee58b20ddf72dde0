//! Datasets in BOP's layout: one written here, and one of a real part, from the folder that `GONIO_POSE` names or from
//! `../shared/pose` beside the checkout (skipped where there is none).

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_pose::bop::{Dataset, Depth, ModelsFolder, encode_depth, parse_results};
use gonio_scene::image::encode_png8;
use gonio_scene::mesh::{Mesh, write_ply};
use std::fs;
use std::path::{Path, PathBuf};

/// A triangle of 30, 40 and 50 mm, 500 mm before a camera of 8 x 6 pixels.
fn dataset(root: &Path) {
    let scene = root.join("test/000007");
    for folder in ["models", "test/000007/rgb", "test/000007/depth"] {
        fs::create_dir_all(root.join(folder)).unwrap();
    }
    let positions = vec![[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 40.0, 0.0]];
    let mesh = Mesh { positions, normals: None, triangles: vec![[0, 1, 2]], degenerate: 0 };
    fs::write(root.join("models/obj_000002.ply"), write_ply(&mesh)).unwrap();
    let info = r#"{"2": {"diameter": 50.0, "symmetries_discrete": [[-1,0,0,10, 0,-1,0,20, 0,0,1,0, 0,0,0,1]],
        "symmetries_continuous": [{"axis": [0, 0, 2], "offset": [5, 0, 0]}]}}"#;
    fs::write(root.join("models/models_info.json"), info).unwrap();
    let camera = r#"{"3": {"cam_K": [100, 0, 4, 0, 100, 3, 0, 0, 1], "depth_scale": 0.1}}"#;
    fs::write(scene.join("scene_camera.json"), camera).unwrap();
    let truth = r#"{"3": [{"obj_id": 2, "cam_R_m2c": [0,-1,0,1,0,0,0,0,1], "cam_t_m2c": [1, 2, 500]}]}"#;
    fs::write(scene.join("scene_gt.json"), truth).unwrap();
    fs::write(scene.join("scene_gt_info.json"), r#"{"3": [{"visib_fract": 0.25}]}"#).unwrap();
    fs::write(scene.join("rgb/000003.png"), encode_png8("rgb", 8, 6, &[[255, 0, 51]; 48]).unwrap()).unwrap();
    let mut metres = vec![0.5f32; 48];
    metres[1] = 0.0;
    metres[2] = 6.6; // beyond 65535 steps of 0.1 mm
    let depth = Depth { width: 8, height: 6, metres };
    fs::write(scene.join("depth/000003.png"), encode_depth("depth", &depth, 1e-4).unwrap()).unwrap();
}

#[test]
fn lengths_become_metres() {
    let folder = tempfile::tempdir().unwrap();
    dataset(folder.path());
    for path in [folder.path().to_owned(), folder.path().join("test")] {
        let data = Dataset::open(&path, None).unwrap();
        let frame = data.frame(7, 3).unwrap();
        let truth = frame.truths[0];
        assert_eq!((frame.depth_step, truth.object, truth.visible), (1e-4, 2, Some(0.25)));
        assert!((truth.pose.translation - glam::DVec3::new(0.001, 0.002, 0.5)).length() < 1e-15);
        // Rows of the file: x of the model goes to y of the camera.
        assert!((truth.pose.rotation * glam::DVec3::X - glam::DVec3::Y).length() < 1e-15);
        let models = data.models(ModelsFolder::Evaluation).unwrap();
        let model = &models[&2];
        assert_eq!(model.mesh.positions[2], [0.0, 0.04, 0.0]);
        assert!((model.diameter - 0.05).abs() < 1e-15);
        assert_eq!(data.size(7, 3).unwrap(), (8, 6));
        assert_eq!(data.colour(7, 3).unwrap().pixels[5], [1.0, 0.0, 0.2]);
        let depth = data.depth(7, 3).unwrap().unwrap();
        assert_eq!((depth.metres[0], depth.metres[1], depth.metres[2]), (0.5, 0.0, 0.0));
    }
}

#[test]
fn symmetries_are_cut_into_steps_as_the_benchmark_does() {
    let folder = tempfile::tempdir().unwrap();
    dataset(folder.path());
    let models = Dataset::open(folder.path(), None).unwrap().models(ModelsFolder::Rendering).unwrap();
    // ceil(pi / 0.01) = 315 steps, without the full turn, after the identity and after the half turn.
    let all = models[&2].symmetries(0.01);
    assert_eq!(all.len(), 2 * 314);
    // The axis stays where it is.
    let axis = glam::DVec3::new(0.005, 0.0, 0.3);
    assert!(all[..314].iter().all(|turn| (turn.apply(axis) - axis).length() < 1e-15));
    let step = glam::DVec3::new(0.105, 0.0, 0.0);
    let way = (all[0].apply(step) - step).length();
    assert!((way - 2.0 * 0.1 * libm::sin(std::f64::consts::PI / 315.0)).abs() < 1e-12);
}

#[test]
fn a_bad_file_is_named_with_key_and_mend() {
    let change = |file: &str, text: &str| {
        let folder = tempfile::tempdir().unwrap();
        dataset(folder.path());
        fs::write(folder.path().join(file), text).unwrap();
        let data = Dataset::open(folder.path(), None);
        data.and_then(|data| data.models(ModelsFolder::Rendering)).unwrap_err().to_string()
    };
    let scene = "test/000007/";
    for (file, text, key) in [
        ("scene_camera.json", r#"{"3": {"cam_K": [0, 0, 4, 0, 100, 3, 0, 0, 1]}}"#, "3.cam_K"),
        ("scene_camera.json", r#"{"3": {"cam_K": [9, 0, 4, 0, 9, 3, 0, 0, 1], "depth_scale": 0}}"#, "3.depth_scale"),
        ("scene_camera.json", r#"{"x": {"cam_K": [9, 0, 4, 0, 9, 3, 0, 0, 1]}}"#, "x"),
        ("scene_gt.json", r#"{"4": []}"#, "4"),
        (
            "scene_gt.json",
            r#"{"3": [{"obj_id": 2, "cam_R_m2c": [1,0,0,0,1,0,0,0,2], "cam_t_m2c": [0,0,1]}]}"#,
            "cam_R_m2c",
        ),
        ("scene_gt_info.json", r#"{"3": []}"#, "3"),
        ("scene_gt_info.json", r#"{"3": [{"visib_fract": 1.5}]}"#, "visib_fract"),
    ] {
        let error = change(&format!("{scene}{file}"), text);
        assert!(error.contains(file) && error.contains(key), "{error}");
    }
    let error = change("models/models_info.json", r#"{"2": {"diameter": -1}}"#);
    assert!(error.contains("models_info.json: 2.diameter"), "{error}");
    let nowhere = Dataset::open(Path::new("/nonexistent"), None).unwrap_err().to_string();
    assert!(nowhere.contains("/nonexistent"), "{nowhere}");
}

#[test]
fn a_real_part_by_another_renderer() {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/pose");
    let root = std::env::var_os("GONIO_POSE").map_or_else(beside, PathBuf::from).join("plug/real");
    let Ok(perfect) = fs::read_to_string(root.join("perfect.csv")) else {
        println!("skipped: no plug/real in GONIO_POSE or ../shared/pose");
        return;
    };
    let data = Dataset::open(&root, None).unwrap();
    assert_eq!(data.frames().count(), 40);
    let models = data.models(ModelsFolder::Evaluation).unwrap();
    let extent = models[&1].vertices().fold(0.0, |far: f64, v| far.max(v.length()));
    assert!((0.04..0.095).contains(&extent), "metres: {extent}");
    // What the file of perfect estimates says is what the dataset says.
    for estimate in parse_results("perfect.csv", &perfect).unwrap() {
        let frame = data.frame(estimate.scene, estimate.image).unwrap();
        assert!((frame.truths[0].pose.translation - estimate.pose.translation).length() < 1e-9);
        assert_eq!(data.size(estimate.scene, estimate.image).unwrap(), (320, 240));
    }
}
