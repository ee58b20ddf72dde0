//! From a sweep to a prediction: datasets in the layout of BOP, estimates, evaluations.

use crate::fixture::{TRUTH, gonio, json, scene, succeeds};
use std::path::Path;
use tempfile::TempDir;

/// The ball stands for a part: what is tested is not how well it is found.
const SWEEP: &str = r#"format = 1
capture = "capture"
samples = 4
outputs = ["rgb"]
resolution = 2

[[model]]
id = 3
objects = ["ball"]
symmetries_continuous = [{ axis = [0, 0, 1] }]

[[view]]
name = "dome"
kind = "hemisphere"
target = [0.0, 0.0, 0.05]
radius = 0.4
elevation = [0.5, 1.4]
count = 5
"#;

/// The poses of another dataset, under another light.
const REPEATED: &str = r#"format = 1
capture = "capture"
samples = 4
outputs = ["rgb"]

[[model]]
id = 3
objects = ["ball"]

[[design]]
kind = "grid"
axes = [{ name = "light.led.intensity", values = [0.1] }]

[[view]]
name = "again"
kind = "bop"
scene = "real/test/000001"
object_id = 3
object = "ball"
size = [64, 48]
"#;

fn swept() -> TempDir {
    let top = scene(TRUTH);
    std::fs::write(top.path().join("sweep.toml"), SWEEP).unwrap();
    std::fs::write(top.path().join("again.toml"), REPEATED).unwrap();
    succeeds(top.path(), &["sweep", "sweep.toml", "--out", "real", "--format", "bop", "--json"]);
    top
}

/// Estimates that are the true poses, shifted by `shift` millimetres along the camera's x.
fn estimates(top: &Path, dataset: &str, shift: f64) -> String {
    let text = std::fs::read_to_string(top.join(dataset).join("test/000001/scene_gt.json")).unwrap();
    let truths: serde_json::Value = serde_json::from_str(&text).unwrap();
    let words =
        |value: &serde_json::Value| value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<f64>>();
    let joined = |values: Vec<f64>| values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let mut lines = "scene_id,im_id,obj_id,score,R,t,time\n".to_owned();
    for (image, list) in truths.as_object().unwrap() {
        let truth = &list[0];
        let mut t = words(&truth["cam_t_m2c"]);
        t[0] += shift;
        lines +=
            &format!("1,{image},{},0.9,{},{},-1\n", truth["obj_id"], joined(words(&truth["cam_R_m2c"])), joined(t));
    }
    lines
}

/// Every file of a dataset with its bytes, the measured times left out.
fn files(root: &Path) -> Vec<(String, Vec<u8>)> {
    let mut list = Vec::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(root).unwrap().display().to_string();
            if path.is_dir() {
                folders.push(path);
            } else if !(name.starts_with("frames") && name.ends_with(".json") || name == "timings.csv") {
                list.push((name, std::fs::read(&path).unwrap()));
            }
        }
    }
    list.sort();
    list
}

#[test]
fn a_sweep_is_a_dataset_whose_own_poses_are_found() {
    let top = swept();
    let scene = top.path().join("real/test/000001");
    for (kind, name) in
        [("rgb", "000004"), ("depth", "000004"), ("mask", "000004_000000"), ("mask_visib", "000004_000000")]
    {
        let image = image::open(scene.join(kind).join(format!("{name}.png"))).unwrap();
        assert_eq!((image.width(), image.height()), (64, 48), "{kind}");
    }
    let info: serde_json::Value =
        serde_json::from_slice(&std::fs::read(scene.join("scene_gt_info.json")).unwrap()).unwrap();
    let entry = &info["0"][0];
    // The ball stands free, and nothing hides it.
    assert_eq!(entry["px_count_all"], entry["px_count_visib"]);
    assert_eq!(entry["visib_fract"], 1.0);
    assert!(entry["px_count_all"].as_u64().unwrap() > 100);
    // Depth lets VSD be computed: with all errors 0, everything is found.
    std::fs::write(top.path().join("true.csv"), estimates(top.path(), "real", 0.0)).unwrap();
    let scores = json(&succeeds(top.path(), &["evaluate", "real", "true.csv", "--json"]));
    assert_eq!((&scores["scores"]["targets"], &scores["scores"]["average_recall"]), (&5.into(), &1.0.into()));
}

#[test]
fn a_dataset_has_the_same_bytes_by_one_thread_and_two_and_when_it_was_stopped() {
    let top = swept();
    let run = |out: &str, more: &[&str]| {
        succeeds(top.path(), &[&["sweep", "sweep.toml", "--out", out, "--format", "bop"], more].concat())
    };
    run("one", &["--threads", "1"]);
    // Stopped in the middle: a frame is lost, and the dataset's files were never written.
    run("two", &["--threads", "2"]);
    std::fs::remove_dir_all(top.path().join("two/test")).unwrap();
    let records = files(&top.path().join("two/frames"));
    std::fs::remove_file(top.path().join("two/frames").join(&records[0].0)).unwrap();
    let told = run("two", &["--json"]);
    assert_eq!(json(&told)["rendered"], 1);
    assert!(files(&top.path().join("one")) == files(&top.path().join("two")));
}

#[test]
fn poses_of_a_dataset_are_repeated_and_predictions_compare_both() {
    let top = swept();
    succeeds(top.path(), &["sweep", "again.toml", "--out", "synthetic", "--format", "bop"]);
    let truth = |dataset: &str| estimates(top.path(), dataset, 0.0);
    let (a, b) = (truth("real"), truth("synthetic"));
    let numbers =
        |text: &str| text.split([',', ' ', '\n']).filter_map(|word| word.parse::<f64>().ok()).collect::<Vec<f64>>();
    // The same poses and image numbers, but for the digits of the way there and back.
    assert!(numbers(&a).iter().zip(numbers(&b)).all(|(a, b)| (a - b).abs() < 1e-6) && numbers(&a).len() == 5 * 17);
    std::fs::write(top.path().join("real.csv"), &a).unwrap();
    std::fs::write(top.path().join("synthetic.csv"), &b).unwrap();
    std::fs::write(top.path().join("off.csv"), estimates(top.path(), "synthetic", 400.0)).unwrap();
    let told = json(&succeeds(
        top.path(),
        &[
            "predict",
            "real",
            "synthetic",
            "--real-results",
            "real.csv",
            "--synthetic-results",
            "synthetic.csv",
            "--contrast",
            "blind=synthetic,off.csv",
            "--setting",
            "good=real.csv,synthetic.csv",
            "--setting",
            "bad=off.csv,off.csv",
            "--out",
            "prediction",
            "--json",
        ],
    ));
    assert_eq!((&told["images"], &told["inside"], &told["equivalent"]), (&5.into(), &true.into(), &true.into()));
    assert_eq!(told["contrasts"][0]["change"]["value"], -1.0);
    assert_eq!(told["settings"]["kendall"], 1.0);
    let page = std::fs::read_to_string(top.path().join("prediction/report.html")).unwrap();
    assert!(page.contains("predict the recall curve") && page.contains("blind"));
    assert!(!page.contains("src=\"http") && !page.contains("<script"));
}

#[test]
#[cfg(unix)]
fn any_program_estimates_and_what_is_done_is_kept() {
    let top = swept();
    std::fs::write(top.path().join("true.csv"), estimates(top.path(), "real", 0.0)).unwrap();
    // Knows the answers, but must be told which image it looks at.
    let script = "import json,sys\nimage, camera, objects = sys.argv[1:]\ncamera = json.load(open(camera))\n\
                  assert camera['width'] == 64 and len(camera['cam_K']) == 9 and objects == '3'\n\
                  number = str(int(image.split('/')[-1].split('.')[0]))\n\
                  print(open('true.csv').readline().strip())\n\
                  print([l for l in open('true.csv') if l.split(',')[1] == number][0].strip())\n";
    std::fs::write(top.path().join("look.py"), script).unwrap();
    let command = "python3 look.py {rgb} {camera} {objects}";
    let run = |more: &[&str]| {
        json(&succeeds(
            top.path(),
            &[&["estimate", "real", "--out", "found.csv", "--estimator", command, "--json"], more].concat(),
        ))
    };
    assert_eq!(run(&[])["estimates"], 5);
    let scores = json(&succeeds(top.path(), &["evaluate", "real", "found.csv", "--json"]));
    assert_eq!(scores["scores"]["average_recall"], 1.0);
    assert!(scores["seconds_per_image"].as_f64().unwrap() > 0.0);
    // Two images are lost: they alone are estimated again.
    let text = std::fs::read_to_string(top.path().join("found.csv")).unwrap();
    let kept: Vec<&str> = text.lines().take(4).collect();
    std::fs::write(top.path().join("found.csv"), kept.join("\n") + "\n").unwrap();
    let again = run(&["--resume"]);
    assert_eq!((&again["images"], &again["estimates"]), (&2.into(), &5.into()));
}

#[test]
fn what_is_wrong_is_named() {
    let top = swept();
    std::fs::write(top.path().join("true.csv"), estimates(top.path(), "real", 0.0)).unwrap();
    let refused = |arguments: &[&str], code: i32, words: &[&str]| {
        let output = gonio(top.path(), arguments);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
        for word in words {
            assert!(stderr.contains(word), "{arguments:?}: {stderr} has no {word:?}");
        }
    };
    let without = |text: &str, name: &str| {
        std::fs::write(top.path().join(name), text).unwrap();
    };
    without(&SWEEP.replace("outputs = [\"rgb\"]", "outputs = [\"exr\"]"), "exr.toml");
    without(&SWEEP[..SWEEP.find("[[model]]").unwrap()].replace("resolution = 2", "photos = [\"01\"]"), "bare.toml");
    without(&SWEEP.replace("[\"ball\"]", "[\"bowl\"]"), "bowl.toml");
    without(&REPEATED.replace("object_id = 3", "object_id = 7"), "seven.toml");
    without(&REPEATED.replace("object = \"ball\"", "object = \"bowl\""), "bowl2.toml");
    let bop = |file: &'static str| ["sweep", file, "--out", "x", "--format", "bop"];
    refused(&bop("exr.toml"), 2, &["exr.toml", "outputs", "rgb"]);
    refused(&bop("bare.toml"), 2, &["bare.toml", "[[model]]"]);
    refused(&bop("bowl.toml"), 2, &["model[0].objects", "bowl", "ball"]);
    refused(&bop("seven.toml"), 2, &["view[0].scene", "object 7", "object_id"]);
    refused(&bop("bowl2.toml"), 2, &["view[0].object", "bowl", "ball"]);
    refused(&["estimate", "nothing", "--out", "f.csv"], 2, &["nothing"]);
    refused(&["estimate", "real", "--out", "f.csv", "--distance", "0.5,0.2"], 2, &["--distance"]);
    refused(&["estimate", "real", "--out", "f.csv", "--estimator", "false {rgb}"], 1, &["estimator", "scene 1 image"]);
    refused(&["estimate", "real", "--out", "f.csv", "--estimator", "no-such {rgb}"], 2, &["no-such"]);
    refused(&["estimate", "real", "--out", "f.csv", "--estimator", "cat"], 2, &["{rgb}"]);
    refused(&["estimate", "real", "--out", "f.csv", "--estimator", "echo 1,2 {rgb}"], 2, &["columns"]);
    let slow = ["estimate", "real", "--out", "f.csv", "--estimator", "sh -c 'sleep 30' {rgb}", "--timeout", "0.2"];
    refused(&slow, 1, &["--timeout", "killed"]);
    refused(&["predict", "real", "nothing", "--out", "p", "--real-results", "true.csv"], 2, &["nothing"]);
    refused(&["predict", "real", "real", "--out", "p", "--margin", "2"], 2, &["--margin"]);
    refused(&["predict", "real", "real", "--out", "p", "--contrast", "base"], 2, &["NAME="]);
}
