//! `gonio matte`, `gonio plan` and `gonio composite`, from photographs to a picture with the part in it.

use crate::fixture::{json, refused, succeeds};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::{read, write_png8};
use std::path::Path;
use tempfile::TempDir;

const SIDE: u32 = 64;
const BLUE: [f64; 3] = [0.1, 0.2, 0.8];
const GREEN: [f64; 3] = [0.2, 0.75, 0.25];

/// Writes `file`: a ball of one colour with a soft border before `back`, or `back` alone.
fn photo(file: &Path, back: [f64; 3], with_ball: bool) {
    let pixel = |k: u32| {
        let (dx, dy) = (f64::from(k % SIDE) - 31.5, f64::from(k / SIDE) - 31.5);
        let alpha = if with_ball { (20.5 - dx.hypot(dy)).clamp(0.0, 1.0) } else { 0.0 };
        std::array::from_fn(|c| (255.0 * (alpha * [0.8, 0.3, 0.2][c] + (1.0 - alpha) * back[c])).round() as u8)
    };
    write_png8(file, SIDE, SIDE, &(0..SIDE * SIDE).map(pixel).collect::<Vec<[u8; 3]>>()).unwrap();
}

fn photographs() -> TempDir {
    let top = tempfile::tempdir().unwrap();
    for (name, back, with_ball) in
        [("a", BLUE, true), ("b", GREEN, true), ("back-a", BLUE, false), ("back-b", GREEN, false)]
    {
        photo(&top.path().join(format!("{name}.png")), back, with_ball);
    }
    top
}

const PAIR: [&str; 9] = ["matte", "--on", "a.png", "--on", "b.png", "--plate", "back-a.png", "--plate", "back-b.png"];

#[test]
fn a_part_is_cut_out_and_blended_into_a_picture() {
    let top = photographs();
    let at = top.path();
    let told = json(&succeeds(at, &[&PAIR[..], &["--out", "m.png", "--json"]].concat()));
    let covered = told["covered"].as_f64().unwrap();
    let truth = std::f64::consts::PI * 20.0 * 20.0 / f64::from(SIDE * SIDE);
    assert!((covered / truth - 1.0).abs() < 0.01, "{covered} {truth}");
    // A colour in place of a plate, and 16 bits.
    let plain = ["matte", "--on", "a.png", "--on", "b.png", "--plate", "#1a33cc", "--plate", "#33bf40"];
    let told = json(&succeeds(at, &[&plain[..], &["--out", "p.png", "--depth", "16", "--json"]].concat()));
    assert!((told["covered"].as_f64().unwrap() - covered).abs() < 0.002, "{told}");
    succeeds(at, &[&PAIR[..], &["--out", "hard.png", "--binary"]].concat());

    let told = succeeds(at, &["plan", "--interval", "45", "--radius", "0.5", "--out", "views.json"]);
    let plan: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(at.join("views.json")).unwrap()).unwrap();
    let views = plan["views"].as_array().unwrap();
    assert!(views.len() > 8 && told.contains(&format!("{} views", views.len())), "{told}");
    for view in views {
        std::fs::copy(at.join("m.png"), at.join(format!("{}.png", view["name"].as_str().unwrap()))).unwrap();
    }
    succeeds(at, &["plan", "--out", "views.csv"]);
    assert_eq!(std::fs::read_to_string(at.join("views.csv")).unwrap().lines().count(), 105);

    write_png8(&at.join("room.png"), 200, 120, &[[40, 40, 40]; 200 * 120]).unwrap();
    let arguments = ["composite", "views.json", "--background", "room.png", "--camera", "10,40,0.5", "--camera"];
    let arguments = [&arguments[..], &["-95,20,0.25", "--out", "frames", "--json"]].concat();
    assert_eq!(json(&succeeds(at, &arguments))["frames"], 2);
    let frames = DirectoryFiles::new(at.join("frames"));
    let red = |name: &str| {
        let frame = read(&frames, name).unwrap();
        assert_eq!((frame.width, frame.height), (200, 120));
        frame.pixels.iter().filter(|pixel| pixel[0] > 0.6 && pixel[2] < 0.4).count() as f64
    };
    // At half the distance the part is twice as wide.
    let (far, near) = (red("frame_0000.png"), red("frame_0001.png"));
    assert!(
        (far / (400.0 * std::f64::consts::PI) - 1.0).abs() < 0.1 && (near / far / 4.0 - 1.0).abs() < 0.1,
        "{far} {near}"
    );
}

#[test]
fn backdrops_that_do_not_fit_are_refused_by_file_and_mend() {
    let top = photographs();
    let at = top.path();
    let out = ["--out", "m.png"];
    let matte = |on: [&'static str; 2], plate: [&'static str; 2]| {
        ["matte", "--on", on[0], "--on", on[1], "--plate", plate[0], "--plate", plate[1], out[0], out[1]]
    };
    let good = ["a.png", "b.png"];
    refused(
        at,
        &matte(good, ["back-b.png", "back-a.png"]),
        &["a.png: --plate: shows its backdrop back-b.png", "order of --on"],
    );
    refused(
        at,
        &matte(["a.png", "a.png"], ["back-a.png", "back-a.png"]),
        &["back-a.png: --plate: and back-a.png are alike", "two backdrops"],
    );
    write_png8(&at.join("small.png"), 8, 8, &[[9; 3]; 64]).unwrap();
    refused(at, &matte(good, ["back-a.png", "small.png"]), &["small.png: --on, --plate: is 8 x 8", "one size"]);
    refused(at, &matte(good, ["back-a.png", "#00ff"]), &["--plate: #00ff: ", "#RRGGBB"]);
    refused(at, &matte(good, ["back-a.png", "none.png"]), &["none.png: ", "correct the path"]);
    refused(
        at,
        &["matte", "--on", "a.png", "--plate", "back-a.png", "--out", "m.png"],
        &["--on, --plate: give each twice"],
    );
    refused(at, &[&PAIR[..], &["--out", "m.png", "--depth", "12"]].concat(), &["--depth", "write 8 or 16"]);
    assert!(!at.join("m.png").exists());
}

#[test]
fn plans_and_composites_without_sense_are_refused_by_file_and_mend() {
    let top = photographs();
    let at = top.path();
    refused(at, &["plan", "--out", "views.txt"], &["views.txt: ", ".json or a .csv"]);
    for interval in ["0", "-3", "nan", "500"] {
        refused(at, &["plan", "--interval", interval, "--out", "v.json"], &["interval"]);
    }
    refused(at, &["plan", "--radius", "0", "--out", "v.json"], &["radius"]);
    succeeds(at, &["plan", "--interval", "60", "--out", "views.json"]);
    let composite = |views: &'static str, more: &[&'static str]| {
        [&["composite", views, "--background", "a.png", "--out", "f"], more].concat()
    };
    let camera = ["--camera", "0,10,1"];
    refused(at, &composite("none.json", &camera), &["none.json: cannot be read", "correct the path"]);
    std::fs::write(at.join("broken.json"), "{\"views\": []}").unwrap();
    refused(at, &composite("broken.json", &camera), &["broken.json: ", "gonio plan"]);
    refused(at, &composite("views.json", &camera), &[".png: cannot be read", "gonio matte"]);
    refused(at, &composite("views.json", &["--camera", "0,10"]), &["--camera", "AZIMUTH,ELEVATION,DISTANCE"]);
    refused(at, &composite("views.json", &["--camera", "0,10,1", "--at", "5"]), &["--at: write two numbers"]);
    refused(
        at,
        &composite("views.json", &["--camera", "0,10,1", "--background", "b.png"]),
        &["--background: 2 pictures for 1 cameras"],
    );
    std::fs::write(at.join("cameras.csv"), "0,10,1\n0,10,none\n").unwrap();
    refused(at, &composite("views.json", &["--cameras", "cameras.csv"]), &["cameras.csv: line 2: holds", "AZIMUTH"]);
    refused(at, &composite("views.json", &["--camera", "0,10,1", "--method", "best"]), &["--method", "alpha-blur"]);
}
