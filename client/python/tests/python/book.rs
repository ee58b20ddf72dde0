//! The listings of the book's chapter about Python.

use crate::interpreter::{capture, crate_folder, interpreter};

/// The chapter's listings, in order; those that are not to be run, "```python ignore", left out.
fn listings() -> String {
    let text = std::fs::read_to_string(crate_folder().join("../book/src/python.md")).unwrap();
    let pieces = text.split("```python\n").skip(1);
    pieces.map(|piece| piece.split("\n```").next().unwrap().to_owned() + "\n").collect()
}

#[test]
fn the_chapter_runs_as_it_stands() {
    let Some(python) = interpreter() else { return };
    let top = tempfile::tempdir().unwrap();
    let repository = capture("none-201").join("../../..");
    for folder in ["tests/captures/none-201", "client/sweep/example"] {
        copy(&repository.join(folder), &top.path().join(folder));
    }
    let text = python.succeeds(top.path(), &listings(), &[]);
    assert!(text.starts_with("<capture 'none-201': 8 photos, "), "{text}");
    assert!(text.lines().any(|line| line.starts_with("material.shell.ior ")), "{text}");
    assert!(top.path().join("fit/report.html").exists() && top.path().join("swept/table.csv").exists());
}

fn copy(from: &std::path::Path, to: &std::path::Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &to);
        } else {
            std::fs::write(to, std::fs::read(entry.path()).unwrap()).unwrap();
        }
    }
}
