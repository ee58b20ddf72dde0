//! The example beside the format's description.

use gonio_scene::Capture;
use gonio_scene::files::DirectoryFiles;
use gonio_sweep::Sweep;
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
fn the_description_lists_every_key_of_the_example() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let format = std::fs::read_to_string(folder.join("FORMAT.md")).unwrap();
    let example = std::fs::read_to_string(folder.join("example/sweep.toml")).unwrap();
    let mut keys = 0;
    for part in example.lines().filter(|line| !line.starts_with('#')).flat_map(|line| line.split(['{', ','])) {
        let Some((key, _)) = part.split_once(" = ") else { continue };
        keys += 1;
        assert!(format.contains(&format!("`{}`", key.trim())), "{key}");
    }
    assert!(keys > 25, "{keys}");
}
