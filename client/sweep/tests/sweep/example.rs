//! The example beside the format's description.

use gonio_scene::Capture;
use gonio_scene::files::{DirectoryFiles, MemoryFiles};
use gonio_sweep::Sweep;
use std::collections::BTreeMap;
use std::path::Path;

#[test]
fn the_example_means_what_its_first_line_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("example");
    let text = std::fs::read_to_string(folder.join("sweep.toml")).unwrap();
    let sweep = Sweep::parse("sweep.toml", &text, 10_000_000).unwrap();
    let capture = Capture::read(&DirectoryFiles::new(folder.join(&sweep.capture))).unwrap();
    let plan = sweep.plan(&capture, &DirectoryFiles::new(&folder)).unwrap();
    assert_eq!((plan.points.len(), plan.frames.len()), (24, 96));
    assert!(text.starts_with("# 3 roughnesses x 8 colours and intensities, each from 4 views: 96 frames."));
}

#[test]
fn the_example_for_bop_means_what_its_first_line_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("example");
    // No fit lies beside the project until its second line is run.
    let text = std::fs::read_to_string(folder.join("bop.toml")).unwrap().replace("../../../fit/fit.json", "fit.json");
    let sweep = Sweep::parse("bop.toml", &text, 10_000_000).unwrap();
    let capture = Capture::read(&DirectoryFiles::new(folder.join(&sweep.capture))).unwrap();
    let fit = r#"{"parameters": [{"name": "material.shell.roughness", "value": 0.4, "standard_error": 0.001}],
        "correlations": [[1.0]]}"#;
    let files = MemoryFiles(BTreeMap::from([("fit.json".to_owned(), fit.as_bytes().into())]));
    let plan = sweep.plan(&capture, &files).unwrap();
    assert_eq!((plan.points.len(), plan.frames.len(), plan.models.len()), (60, 60, 1));
    assert!(text.starts_with("# 60 views of the knob"));
}

#[test]
fn the_description_lists_every_key_of_the_example() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let format = std::fs::read_to_string(folder.join("FORMAT.md")).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.join("example").join(name)).unwrap();
    let example = read("sweep.toml") + &read("bop.toml");
    let mut keys = 0;
    for part in example.lines().filter(|line| !line.starts_with('#')).flat_map(|line| line.split(['{', ','])) {
        let Some((key, _)) = part.split_once(" = ") else { continue };
        keys += 1;
        assert!(format.contains(&format!("`{}`", key.trim())), "{key}");
    }
    assert!(keys > 25, "{keys}");
}
