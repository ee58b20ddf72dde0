//! The example scripts run as they are, in a folder that is not the repository's.

use crate::interpreter::{capture, crate_folder, interpreter, printed};

fn example(name: &str, says: &[&str]) {
    let Some(python) = interpreter() else { return };
    let at = tempfile::tempdir().unwrap();
    let script = crate_folder().join("examples").join(name);
    let text = printed(&python.command(at.path()).arg(script).arg(capture("none-201")).output().unwrap());
    for line in says {
        assert!(text.contains(line), "no {line:?} in:\n{text}");
    }
}

#[test]
fn render_changes_with_what_is_set() {
    let refusal = "material.shell.roughness: is set to 1.7; it must be 0..=1";
    example("render.py", &["00: float32 (120, 160, 3)", "knob: ", refusal]);
}

#[test]
fn fit_finds_values_and_keeps_them() {
    example(
        "fit.py",
        &["6 names free", "fitting 6 parameters to 6 photos by gauss-newton", ": converged", "photo 03: "],
    );
}

#[test]
fn sweep_gives_frames_as_they_are_finished() {
    example("sweep.py", &["roughness 0.2: brightest photo value"]);
}
