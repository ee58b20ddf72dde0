//! The package's types, held against itself and its examples by mypy, and its stubs against the compiled module.

use crate::interpreter::{crate_folder, interpreter, printed};

#[test]
fn the_type_checker_has_nothing_to_say() {
    let Some(python) = interpreter() else { return };
    let at = tempfile::tempdir().unwrap();
    let there = python.run(at.path(), "import mypy", &[]).status.success();
    if !there {
        eprintln!("skipped: this Python has no mypy");
        return;
    }
    let package = python.package();
    assert!(package.join("py.typed").exists());
    let mut strict = python.command(at.path());
    strict.args(["-m", "mypy", "--strict"]).arg(&package).arg(crate_folder().join("examples"));
    let text = printed(&strict.output().unwrap());
    assert!(text.contains("Success: no issues found"), "{text}");
    let stubs = python.command(at.path()).args(["-m", "mypy.stubtest", "gonio._native"]).output().unwrap();
    assert!(printed(&stubs).contains("no issues found"));
}
