//! Bad sweeps: one error that names file, key and mend.

use crate::fixture::{HEAD, capture, plan_of};
use gonio_scene::files::MemoryFiles;
use gonio_sweep::Sweep;

const AXES: &str = "axes = [{ name = \"material.shell.roughness\", values = [0.5] }]";

/// Lines after the head, and what the error must name.
const CASES: &[(&str, &[&str])] = &[
    ("smaples = 4", &["sweep.toml: smaples", "did you mean `samples`"]),
    ("samples = 7", &["samples", "even"]),
    ("samples = 0", &["samples", "2..="]),
    ("samples = \"many\"", &["samples", "whole number"]),
    ("seed = -1", &["seed", "0..="]),
    ("resolution = nan", &["resolution", "NaN"]),
    ("resolution = 1e5", &["resolution", "smaller"]),
    ("png_stops = inf", &["png_stops"]),
    ("outputs = []", &["outputs", "empty"]),
    ("outputs = [\"jpeg\"]", &["outputs", "exr, png, rgb, buffers"]),
    ("photos = [\"07\"]", &["photos", "\"07\"", "00, 01"]),
    ("photos = [\"00\", \"00\"]", &["photos", "twice"]),
    ("seeds = \"some\"", &["seeds", "\"shared\", \"independent\""]),
    ("combine = 1", &["combine", "text"]),
    ("design = 3", &["design", "list of tables"]),
    ("[[design]]\nkind = \"gird\"\nAXES", &["design[0].kind", "\"grid\""]),
    ("[[design]]\nAXES", &["design[0].kind", "missing"]),
    ("[[design]]\nkind = \"grid\"", &["design[0].axes", "missing or empty"]),
    ("[[design]]\nkind = \"grid\"\naxes = []", &["design[0].axes", "missing or empty"]),
    ("[[design]]\nkind = \"grid\"\ncount = 3\nAXES", &["design[0].count", "not a key"]),
    ("[[design]]\nkind = \"sobol\"\nAXES", &["design[0].count", "missing"]),
    ("[[design]]\nkind = \"sobol\"\ncount = 0\nAXES", &["design[0].count", "1..=65536"]),
    ("[[design]]\nkind = \"latin-hypercube\"\ncount = 10000000\nAXES", &["design[0].count", "1..=1000000"]),
    ("[[design]]\nkind = \"grid\"\naxes = [{ values = [1] }]", &["design[0].axes[0].name", "missing"]),
    ("GRID{ name = \"material.shell.roughnes\", values = [1] }]", &["axes[0].name", "material.shell.roughness"]),
    ("GRID{ name = \"sensor.read_noise\", values = [1] }]", &["axes[0].name", "changes no render"]),
    ("GRID{ name = \"material.shell.roughness\", values = [0.5, 1.5] }]", &["axes[0].values", "1.5", "0..=1"]),
    ("GRID{ name = \"material.shell.roughness\", values = [nan] }]", &["axes[0].values", "NaN"]),
    ("GRID{ name = \"material.shell.roughness\", values = [] }]", &["axes[0].values", "at least one"]),
    ("GRID{ name = \"material.shell.roughness\", values = [[]] }]", &["axes[0].values", "empty list"]),
    ("GRID{ name = \"material.shell.base_color\", values = [[0.1, 0.2]] }]", &["axes[0].values", "2 numbers", "3"]),
    ("GRID{ name = \"material.shell.roughness\", from = 0.1, to = 0.5 }]", &["axes[0].count", "missing"]),
    ("GRID{ name = \"material.shell.roughness\", from = 0.1, to = 0.5, count = 1 }]", &["axes[0].count", "at least 2"]),
    ("GRID{ name = \"material.shell.roughness\", from = 0.5, to = 0.1, count = 3 }]", &["axes[0].from", "swap"]),
    (
        "GRID{ name = \"material.shell.roughness\", from = 0, to = 1, count = 3, scale = \"log\" }]",
        &["from", "logarithm"],
    ),
    ("GRID{ name = \"material.shell.roughness\", from = 0, to = 2, count = 3 }]", &["axes[0].to", "0..=1"]),
    ("GRID{ name = \"material.shell.roughness\", values = [1], from = 0 }]", &["axes[0].from", "not a key"]),
    (
        "GRID{ name = \"material.shell.base_color\", values = [0.5] }, { name = \"material.shell.base_color.g\", values = [0.5] }]",
        &["design[0]", "base_color.g twice"],
    ),
    (
        "GRID{ name = \"material.shell.roughness\", from = 0, to = 1, count = 10000 }, { name = \"material.shell.ior\", from = 1.2, to = 2, count = 10000 }]",
        &["design[0].axes", "more than 1000000"],
    ),
    (
        "GRID{ name = \"photo.01.camera_to_world.0.0\", values = [5] }]",
        &["sweep.toml: design", "camera_to_world", "rotation"],
    ),
    ("[[design]]\nkind = \"csv\"", &["design[0].file", "missing"]),
    ("[[design]]\nkind = \"csv\"\nfile = \"absent.csv\"", &["absent.csv"]),
    ("[[view]]\nkind = \"hemisphere\"", &["view[0].name", "missing"]),
    ("[[view]]\nname = \"a/b\"\nkind = \"pose\"", &["view[0].name", "letters"]),
    ("[[view]]\nname = \"v\"\nkind = \"dome\"", &["view[0].kind", "\"hemisphere\""]),
    ("VIEW\nradius = 0", &["view[0].radius"]),
    ("VIEW\nradius = [2, 1]", &["view[0].radius", "[least, most]"]),
    ("VIEW\nradius = 1\nelevation = 2", &["view[0].elevation"]),
    ("VIEW\nradius = 1\ncuont = 3", &["view[0].cuont", "did you mean `count`"]),
    ("VIEW\nradius = 1\nlights = [\"sun\"]", &["sweep.toml: view", "sun"]),
    ("VIEW\nradius = 1\n[view.camera]\nwidth = 0", &["view[0].camera.width"]),
    ("VIEW\nradius = 1\n[view.camera]\nhieght = 1", &["view[0].camera.hieght", "did you mean `height`"]),
    ("[[view]]\nname = \"00\"\nkind = \"look-at\"\nposition = [1, 0, 0]\ntarget = [0, 0, 0]", &["view", "twice"]),
    ("[[view]]\nname = \"v\"\nkind = \"look-at\"\nposition = [1, 0, 0]\ntarget = [1, 0, 0]", &["position", "away"]),
    ("[[view]]\nname = \"v\"\nkind = \"pose\"\ncamera_to_world = [[1]]", &["camera_to_world", "4x4"]),
    (
        "[[view]]\nname = \"v\"\nkind = \"pose\"\ncamera_to_world = [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
        &["view[0].camera_to_world", "no rotation"],
    ),
    ("[[view]]\nname = \"v\"\nkind = \"hemisphere\"\ntarget = [0, 0, 0]\nradius = 1\ncount = 9999", &["view", "10000"]),
    ("[[", &["sweep.toml", "TOML"]),
];

#[test]
fn every_mistake_has_an_error_that_names_its_place() {
    for (lines, expected) in CASES {
        let lines = lines
            .replace("AXES", AXES)
            .replace("GRID", "[[design]]\nkind = \"grid\"\naxes = [")
            .replace("VIEW", "[[view]]\nname = \"v\"\nkind = \"hemisphere\"\ntarget = [0, 0, 0]\ncount = 3");
        let error = plan_of(&capture(), &lines, "").unwrap_err().to_string();
        assert!(expected.iter().all(|part| error.contains(part)), "{lines}\n{error}\n{expected:?}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn the_head_is_needed() {
    for (text, expected) in [
        ("capture = \"c\"", "format: is missing"),
        ("format = 2\ncapture = \"c\"", "format: is not 1"),
        ("format = 1", "capture: is missing"),
        ("format = 1\ncapture = \"\"", "capture: is empty"),
    ] {
        let error = Sweep::parse("a/sweep.toml", text, 100).unwrap_err().to_string();
        assert!(error.contains("a/sweep.toml") && error.contains(expected), "{error}");
    }
    assert!(Sweep::parse("s", &format!("{HEAD}samples = 102"), 100).is_err(), "the farm's limit holds");
}

#[test]
fn broken_lists_name_the_line() {
    for (list, expected) in [
        ("", "is empty"),
        ("# nothing\n\n", "is empty"),
        ("material.shell.roughness\n", "has no point"),
        ("material.shell.roughnes\n0.1", "line 1"),
        ("material.shell.roughness\n0.1\n0.2,0.3", "line 3"),
        ("material.shell.roughness\n\n0.1x", "line 3"),
        ("material.shell.roughness\nnan", "no finite number"),
        ("material.shell.roughness\ninf", "no finite number"),
        ("material.shell.roughness\n1.2", "0..=1"),
        ("material.shell.roughness,material.shell.roughness\n0.1,0.1", "twice"),
    ] {
        let error =
            plan_of(&capture(), "[[design]]\nkind = \"csv\"\nfile = \"list.csv\"", list).unwrap_err().to_string();
        assert!(error.contains(expected), "{list:?}: {error}");
    }
    let binary = MemoryFiles([("list.csv".to_owned(), std::sync::Arc::from(&[0xff, 0xfe, 0][..]))].into());
    let sweep = Sweep::parse("s", &format!("{HEAD}[[design]]\nkind = \"csv\"\nfile = \"list.csv\""), 100).unwrap();
    assert!(sweep.plan(&capture(), &binary).unwrap_err().to_string().contains("list.csv: is not UTF-8"));
}
