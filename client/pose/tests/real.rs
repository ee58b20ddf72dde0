//! The benchmark's own data, from the folder that `GONIO_REAL` names, or from `../shared/real` beside the checkout; skipped
//! where there is none: a photograph of LM-O with depth, mesh and pose, and tables of true and estimated poses.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_pose::Pose;
use gonio_pose::bop::{Dataset, Estimate, Model, Models, ModelsFolder, parse_results};
use gonio_pose::evaluate::{default_targets, evaluate};
use gonio_pose::render;
use gonio_scene::mesh::Mesh;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn real(name: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    let folder = std::env::var_os("GONIO_REAL").map_or_else(beside, PathBuf::from).join(name);
    if !folder.is_dir() {
        println!("skipped: no {name} in GONIO_REAL or ../shared/real");
        return None;
    }
    Some(folder)
}

fn read_json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// The photograph as a dataset: the mesh of object 5 alone is there.
fn watering_can(from: &Path, to: &Path) -> Dataset {
    let scene = to.join("test/000002");
    for folder in ["models", "test/000002/rgb", "test/000002/depth"] {
        fs::create_dir_all(to.join(folder)).unwrap();
    }
    fs::copy(from.join("obj_000005.ply"), to.join("models/obj_000005.ply")).unwrap();
    fs::copy(from.join("rgb.png"), scene.join("rgb/000003.png")).unwrap();
    fs::copy(from.join("depth.png"), scene.join("depth/000003.png")).unwrap();
    // The largest distance of two vertices that LM-O states.
    fs::write(to.join("models/models_info.json"), json!({"5": {"diameter": 201.404}}).to_string()).unwrap();
    fs::write(scene.join("scene_camera.json"), json!({"3": read_json(&from.join("camera.json"))}).to_string()).unwrap();
    let truth = read_json(&from.join("gt_pose_scene2_im3.json"));
    let can: Vec<&Value> = truth["gt"].as_array().unwrap().iter().filter(|entry| entry["obj_id"] == 5).collect();
    fs::write(scene.join("scene_gt.json"), json!({ "3": can }).to_string()).unwrap();
    Dataset::open(to, None).unwrap()
}

#[test]
fn the_depth_of_the_mesh_at_its_pose_is_what_the_sensor_measured() {
    let Some(from) = real("bop-lmo") else { return };
    let folder = tempfile::tempdir().unwrap();
    let data = watering_can(&from, folder.path());
    let models = data.models(ModelsFolder::Evaluation).unwrap();
    let frame = data.frame(2, 3).unwrap();
    let measured = data.depth(2, 3).unwrap().unwrap();
    assert_eq!(data.size(2, 3).unwrap(), (measured.width, measured.height));
    let seen = render::depth(&models[&5].mesh, &frame.truths[0].pose, &frame.camera, measured.width, measured.height);
    let mut apart: Vec<f32> = seen
        .metres
        .iter()
        .zip(&measured.metres)
        .filter(|(seen, measured)| **seen > 0.0 && **measured > 0.0)
        .map(|(seen, measured)| (seen - measured).abs())
        .collect();
    apart.sort_by(f32::total_cmp);
    let median = apart[apart.len() / 2];
    println!("median |dz| {:.2} mm over {} pixels", 1e3 * median, apart.len());
    // Points scattered over the mesh by another program, those within 0.15 pixels of a pixel's centre: 7.3 mm over 4329
    // pixels (8.1 mm over 4443 where the whole pixel counts). A millimetre taken for a metre, or an image off, is far out.
    assert!((4200..4400).contains(&apart.len()), "{}", apart.len());
    assert!((0.0065..0.0075).contains(&median), "{median}");
}

#[test]
fn a_photograph_evaluates() {
    let (Some(from), Some(tables)) = (real("bop-lmo"), real("bop-toolkit-csv")) else { return };
    let folder = tempfile::tempdir().unwrap();
    let data = watering_can(&from, folder.path());
    let models = data.models(ModelsFolder::Evaluation).unwrap();
    let targets = default_targets(&data);
    let run = |estimates: &[Estimate]| evaluate(&data, &models, &targets, estimates).unwrap().scores.unwrap();
    let truth = data.frame(2, 3).unwrap().truths[0].pose;
    let estimate = |pose| Estimate { scene: 2, image: 3, object: 5, score: 1.0, pose, seconds: None };
    let perfect = run(&[estimate(truth)]);
    assert_eq!((perfect.targets, perfect.average_recall), (1, Some(1.0)));
    // 3 cm aside is 0.149 diameters (8 of 10 thresholds) and 0.03 f / z = 17.8 px at the centre.
    let shift = Pose { translation: truth.translation + glam::DVec3::new(0.03, 0.0, 0.0), ..truth };
    let aside = run(&[estimate(shift)]);
    assert!((aside.mssd - 0.8).abs() < 1e-12 && aside.mspd < 0.75 && aside.vsd.unwrap() < 1.0, "{aside:?}");
    assert_eq!(run(&[]).average_recall, Some(0.0));
    // What CNOS and MegaPose found in this image.
    let name = "cnos-fastsammegapose_lmo-test_16ab01bd-f020-4194-9750-d42fc7f875d2.csv";
    let found = parse_results(name, &fs::read_to_string(tables.join(name)).unwrap()).unwrap();
    let here: Vec<Estimate> = found.into_iter().filter(|e| (e.scene, e.image, e.object) == (2, 3, 5)).collect();
    println!("{} estimates: {:?}", here.len(), run(&here));
}

#[test]
fn true_poses_find_every_target_and_estimates_are_read_to_the_last() {
    let Some(tables) = real("bop-toolkit-csv") else { return };
    let load = |name: &str| parse_results(name, &fs::read_to_string(tables.join(name)).unwrap()).unwrap();
    for (truth, rows, found, found_rows) in [
        (
            "gt-pbrreal-rgb-mmodel_lmo-test_lmo.csv",
            1445,
            "cnos-fastsammegapose_lmo-test_16ab01bd-f020-4194-9750-d42fc7f875d2.csv",
            1645,
        ),
        (
            "gt-pbrreal-rgb-mmodel_tless-test_tless.csv",
            6721,
            "cnos-fastsammegapose_tless-test_94e046a0-42af-495f-8a35-11ce8ee6f217.csv",
            7001,
        ),
    ] {
        let (truths, found) = (load(truth), load(found));
        assert_eq!((truths.len(), found.len()), (rows, found_rows));
        let folder = tempfile::tempdir().unwrap();
        let data = poses_alone(&truths, folder.path());
        let models = stand_ins(&truths);
        let targets = default_targets(&data);
        let scores = |estimates: &[Estimate]| evaluate(&data, &models, &targets, estimates).unwrap().scores.unwrap();
        // Several of an object in an image, in any order, are told apart by their errors.
        let backwards: Vec<Estimate> = truths.iter().rev().copied().collect();
        let own = scores(&backwards);
        assert_eq!((own.targets, own.mssd, own.mspd), (rows, 1.0, 1.0), "{truth}");
        assert_eq!((own.degrees_5_cm_5, own.average_recall), (1.0, None));
        let theirs = scores(&found);
        println!("{truth}: 5 degrees and 5 cm {:.4}", theirs.degrees_5_cm_5);
        assert!((0.05..0.95).contains(&theirs.degrees_5_cm_5));
    }
}

/// A dataset of true poses without depth; the images are tiny files, for their width.
fn poses_alone(truths: &[Estimate], root: &Path) -> Dataset {
    let mut scenes: BTreeMap<u32, BTreeMap<u32, Vec<Value>>> = BTreeMap::new();
    for e in truths {
        let shift = e.pose.translation.to_array().map(|x| x * 1e3);
        let entry = json!({"obj_id": e.object, "cam_R_m2c": e.pose.rows(), "cam_t_m2c": shift});
        scenes.entry(e.scene).or_default().entry(e.image).or_default().push(entry);
    }
    let png = gonio_scene::image::encode_png8("rgb", 640, 1, &[[0; 3]; 640]).unwrap();
    for (scene, images) in scenes {
        let folder = root.join(format!("test/{scene:06}"));
        fs::create_dir_all(folder.join("rgb")).unwrap();
        let camera = json!({"cam_K": [570, 0, 320, 0, 570, 240, 0, 0, 1], "depth_scale": 1.0});
        let cameras: BTreeMap<_, _> = images.keys().map(|image| (image.to_string(), camera.clone())).collect();
        fs::write(folder.join("scene_camera.json"), json!(cameras).to_string()).unwrap();
        fs::write(folder.join("scene_gt.json"), json!(images).to_string()).unwrap();
        for image in images.keys() {
            fs::write(folder.join(format!("rgb/{image:06}.png")), &png).unwrap();
        }
    }
    Dataset::open(root, None).unwrap()
}

/// A tetrahedron in place of every model.
fn stand_ins(truths: &[Estimate]) -> Models {
    let positions = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
    let mesh = Mesh { positions, normals: None, triangles: vec![[0, 1, 2]], degenerate: 0 };
    let model = Model { mesh, diameter: 0.1414, discrete: Vec::new(), continuous: Vec::new() };
    truths.iter().map(|e| (e.object, model.clone())).collect()
}
