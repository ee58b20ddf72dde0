//! `gonio export`.

use crate::fixture::{TRUTH, capture_file, edit, json, refused, scene, succeeds};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::mesh;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

const FORMATS: [&str; 5] = ["mitsuba", "blender", "usd", "gltf", "pbrt"];

/// Exports the fixture's capture to `out` below its folder; gives what `--json` tells.
fn exported(top: &TempDir, format: &str, out: &str) -> Value {
    json(&succeeds(top.path(), &["export", "capture", "--to", format, "--out", out, "--json"]))
}

/// The text of a file.
fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// Whether every tag is closed by its own, and nothing stands outside of the only outermost one.
fn is_xml(text: &str) -> bool {
    let mut open: Vec<&str> = Vec::new();
    let mut roots = 0;
    for piece in text.split('<').skip(1) {
        let Some((tag, _)) = piece.split_once('>') else { return false };
        let name = tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap_or_default();
        match tag {
            _ if tag.starts_with(['?', '!']) => {}
            _ if tag.starts_with('/') => {
                if open.pop() != Some(name) {
                    return false;
                }
            }
            _ => {
                roots += usize::from(open.is_empty());
                if !tag.ends_with('/') {
                    open.push(name);
                }
            }
        }
    }
    open.is_empty() && roots == 1
}

/// Whether brackets outside of strings close in the order in which they open.
fn is_balanced(text: &str) -> bool {
    let (mut open, mut inside, mut escaped) = (Vec::new(), false, false);
    for c in text.lines().filter(|line| !line.trim_start().starts_with('#')).flat_map(str::chars) {
        match c {
            _ if escaped => escaped = false,
            '\\' if inside => escaped = true,
            '"' => inside = !inside,
            _ if inside => {}
            '(' | '[' | '{' => open.push(c),
            ')' | ']' | '}' => {
                let opened = match c {
                    ')' => '(',
                    ']' => '[',
                    _ => '{',
                };
                if open.pop() != Some(opened) {
                    return false;
                }
            }
            _ => {}
        }
    }
    open.is_empty() && !inside
}

/// The JSON inside of a binary glTF file, whose header and chunks must have the sizes that they state.
fn gltf(bytes: &[u8]) -> Value {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let length = word(12);
    assert_eq!((&bytes[16..20], &bytes[24 + length..28 + length]), (&b"JSON"[..], &b"BIN\0"[..]));
    assert_eq!(28 + length + word(20 + length), bytes.len());
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

/// Parses a file by what its name says that it is.
fn parses(root: &Path, name: &str) {
    let path = root.join(name);
    match name.rsplit_once('.').map(|(_, ending)| ending) {
        Some("json") => drop(serde_json::from_str::<Value>(&text(&path)).unwrap()),
        Some("xml") => assert!(is_xml(&text(&path)), "{name}"),
        Some("ply") => {
            let mesh = mesh::read(&DirectoryFiles::new(root), name).unwrap();
            assert!(mesh.triangles.len() >= 2, "{name}");
        }
        Some("usda") => {
            let text = text(&path);
            assert!(text.starts_with("#usda 1.0") && is_balanced(&text), "{name}");
        }
        Some("glb") => {
            let gltf = gltf(&std::fs::read(&path).unwrap());
            assert_eq!(gltf["asset"]["version"], "2.0");
            assert_eq!(gltf["meshes"].as_array().unwrap().len(), 2);
        }
        Some("pbrt") => {
            let text = text(&path);
            assert_eq!(text.matches("WorldBegin").count(), 1, "{name}");
            assert!(is_balanced(&text), "{name}");
        }
        // Python reads its own files below.
        Some("py") => {}
        other => panic!("{name}: a file of kind {other:?}, which this test does not know"),
    }
}

#[test]
fn every_format_writes_files_that_parse_and_lists_them() {
    let top = scene(TRUTH);
    for format in FORMATS {
        let told = exported(&top, format, format);
        let root = top.path().join(format);
        assert_eq!(told, serde_json::from_str::<Value>(&text(&root.join("export.json"))).unwrap());
        assert_eq!((&told["format"], &told["capture"]), (&Value::from(format), &Value::from("ball on a board")));
        assert_eq!(told["photos"].as_array().unwrap().len(), 4);
        let files: Vec<&str> = told["files"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
        assert!(files.contains(&"sensor.py"), "{format}: {files:?}");
        files.iter().for_each(|name| parses(&root, name));
    }
}

#[test]
fn python_compiles_the_scripts() {
    let compiles = |path: &Path| Command::new("python3").args(["-m", "py_compile"]).arg(path).output();
    let top = scene(TRUTH);
    for format in FORMATS {
        let told = exported(&top, format, format);
        for name in told["files"].as_array().unwrap().iter().filter_map(Value::as_str).filter(|n| n.ends_with(".py")) {
            let Ok(output) = compiles(&top.path().join(format).join(name)) else {
                println!("skipped: there is no python3 here");
                return;
            };
            assert!(output.status.success(), "{format}/{name}: {}", String::from_utf8_lossy(&output.stderr));
        }
    }
}

#[test]
fn the_table_says_what_the_record_says() {
    let top = scene(TRUTH);
    // A sheen is what Mitsuba's plastic lacks.
    edit(&capture_file(&top), "roughness = 0.35\n", "roughness = 0.35\nsheen_color = [0.1, 0.2, 0.3]\n");
    for format in FORMATS {
        let table = succeeds(top.path(), &["export", "capture", "--to", format, "--out", "out"]);
        let told = exported(&top, format, "out");
        let numbers = told["numbers"].as_array().unwrap();
        let count = |word: &str| numbers.iter().filter(|number| number["kept"] == word).count();
        let all = numbers.len();
        assert_eq!(count("exact") + count("approximated") + count("lost"), all);
        assert!(table.contains(&format!("exact        {} of {all} numbers", count("exact"))), "{table}");
        // A line stands for one number, or for as many as it says.
        for word in ["approximated", "lost"] {
            let lines = table.lines().filter(|line| line.starts_with(word));
            let many = |line: &str| {
                let bracket = line.split_once(" (").and_then(|(_, rest)| rest.split_once(')'));
                bracket.and_then(|(number, _)| number.parse().ok()).unwrap_or(1)
            };
            assert_eq!(lines.map(many).sum::<usize>(), count(word), "{format} {word}:\n{table}");
        }
        let files = told["files"].as_array().unwrap().len() + 1;
        assert!(table.contains(&format!("exported ball on a board for {format} to out: {files} files")), "{table}");
    }
    let lost = |format: &str| {
        let told = exported(&top, format, "out");
        let name = "material.shell.sheen_color.r";
        let found = told["numbers"].as_array().unwrap().iter().find(|number| number["name"] == name).unwrap().clone();
        found["kept"].as_str().unwrap().to_owned()
    };
    assert_eq!(lost("mitsuba"), "lost");
    assert_ne!(lost("gltf"), "lost");
}

#[test]
fn bad_words_and_captures_are_refused() {
    let top = scene(TRUTH);
    let at = top.path();
    refused(at, &["export", "capture", "--to", "maya", "--out", "out"], &["maya", "mitsuba, blender, usd, gltf, pbrt"]);
    refused(at, &["export", "capture", "--out", "out"], &["--to <FORMAT>"]);
    refused(at, &["export", "capture", "--to", "usd"], &["--out <DIR>"]);
    refused(at, &["export", "nowhere", "--to", "usd", "--out", "out"], &["nowhere: does not exist"]);
    std::fs::write(at.join("file"), "").unwrap();
    refused(at, &["export", "capture", "--to", "usd", "--out", "file"], &["file", "--out"]);
    std::fs::write(at.join("capture/ball.ply"), "ply\nnonsense").unwrap();
    refused(at, &["export", "capture", "--to", "usd", "--out", "out"], &["ball.ply"]);
    std::fs::remove_file(at.join("capture/ball.ply")).unwrap();
    refused(at, &["export", "capture", "--to", "usd", "--out", "out"], &["ball.ply"]);
    assert!(!at.join("out").exists(), "something was written");
}

#[test]
fn never_writes_over_the_capture() {
    let top = scene(TRUTH);
    let root = top.path().join("capture");
    std::fs::create_dir(root.join("meshes")).unwrap();
    std::fs::rename(root.join("ball.ply"), root.join("meshes/ball.ply")).unwrap();
    edit(&capture_file(&top), "mesh = \"ball.ply\"", "mesh = \"meshes/ball.ply\"");
    let before = std::fs::read(root.join("meshes/ball.ply")).unwrap();
    refused(top.path(), &["export", "capture", "--to", "mitsuba", "--out", "capture"], &["ball.ply", "--out"]);
    assert_eq!(std::fs::read(root.join("meshes/ball.ply")).unwrap(), before);
}

/// Renders photo 00 in Mitsuba and gives its mean as the sensor would have measured it.
const MITSUBA: &str = "
import sys
sys.path.insert(0, '.')
import mitsuba as mi, numpy as np
mi.set_variant('scalar_rgb')
import scene, sensor
image = np.array(mi.render(scene.load('00'), spp=256))
print(float(sensor.photograph(image, '00').mean()))
";

#[test]
fn mitsuba_renders_the_same() {
    let program = std::env::var("GONIO_TEST_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let able = Command::new(&program).args(["-c", "import mitsuba, numpy"]).output();
    if !able.is_ok_and(|output| output.status.success()) {
        println!("skipped: {program} has no mitsuba");
        return;
    }
    let top = scene(TRUTH);
    exported(&top, "mitsuba", "out");
    let output =
        Command::new(program).args(["-B", "-c", MITSUBA]).current_dir(top.path().join("out")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let theirs: f64 = String::from_utf8_lossy(&output.stdout).trim().parse().unwrap();
    let words = ["render", "capture", "--out", "render", "--samples", "256", "--photos", "00", "--json"];
    let means = json(&succeeds(top.path(), &words))["photos"][0]["mean"].clone();
    let ours: f64 = means.as_array().unwrap().iter().map(|mean| mean.as_f64().unwrap()).sum::<f64>() / 3.0;
    // Both are off by their noise, some tenths of a per cent at 256 samples.
    assert!((theirs / ours - 1.0).abs() < 0.01, "{theirs} {ours}");
}
