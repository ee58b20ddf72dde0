//! What cannot be exported is refused in one line.

use crate::fixture::{files, full, plain};
use gonio_export::{Format, export};
use gonio_scene::Capture;
use std::sync::Arc;

fn refused(capture: &Capture, files: &gonio_scene::files::MemoryFiles, says: &[&str]) {
    for format in Format::ALL {
        let error = export(capture, files, format).unwrap_err().to_string();
        assert!(!error.contains('\n'), "{error}");
        for text in says {
            assert!(error.contains(text), "{format}: no {text:?} in {error}");
        }
    }
}

#[test]
fn missing_things_are_named_by_file_key_and_mend() {
    let capture = Capture::parse(&plain()).unwrap();
    let files = files();
    let blind = Capture { photos: Vec::new(), ..capture.clone() };
    refused(&blind, &files, &["capture.toml: photo: is missing", "add at least one [[photo]]"]);
    let empty = Capture { objects: Vec::new(), ..capture.clone() };
    refused(&empty, &files, &["capture.toml: object: is missing", "add at least one [[object]]"]);
    let mut without = files.clone();
    without.0.remove("part.ply");
    refused(&capture, &without, &["part.ply"]);
    let mut broken = files.clone();
    broken.0.insert("part.ply".into(), Arc::from(&b"ply\nnonsense"[..]));
    refused(&capture, &broken, &["part.ply"]);
    let mut dark = files;
    dark.0.remove("room.exr");
    refused(&Capture::parse(&full()).unwrap(), &dark, &["room.exr"]);
}

#[test]
fn words_are_formats_or_refused() {
    for format in Format::ALL {
        assert_eq!(format.word().parse(), Ok(format));
    }
    let error = "maya".parse::<Format>().unwrap_err();
    assert_eq!(error, "write one of: mitsuba, blender, usd, gltf, pbrt");
}

#[test]
fn names_cannot_leave_the_folder() {
    let odd =
        plain().replace("name = \"part\"\nmesh", "name = \"../../x \\\" y\"\nmesh").replace("shell", "a<b>&\\\"c");
    let capture = Capture::parse(&odd).unwrap();
    for format in Format::ALL {
        let export = export(&capture, &files(), format).unwrap();
        assert!(export.files.keys().all(|name| !name.contains("..") && !name.contains([' ', '"'])), "{format}");
    }
}
