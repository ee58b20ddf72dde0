//! A capture of two photos, and sweeps of it.

use gonio_scene::files::MemoryFiles;
use gonio_scene::{Capture, Result};
use gonio_sweep::{FrameDigest, Plan, Sweep};
use std::collections::BTreeMap;
use std::sync::Arc;

pub const CAPTURE: &str = r#"
format = 1
name = "ball"
[camera]
width = 32
height = 24
fx = 48.0
fy = 48.0
cx = 16.0
cy = 12.0
[[material]]
name = "shell"
model = "plastic"
base_color = [0.5, 0.4, 0.3]
roughness = 0.4
ior = 1.5
[[object]]
name = "ball"
mesh = "ball.ply"
material = "shell"
object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
[[light]]
name = "led"
kind = "point"
frame = "camera"
position = [0.05, 0.0, 0.0]
intensity = [0.2, 0.2, 0.2]
[[photo]]
file = "photos/00.exr"
camera_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -1], [0, 0, 0, 1]]
[[photo]]
file = "photos/01.exr"
exposure = 2.0
camera_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -2], [0, 0, 0, 1]]
[fit]
parameters = ["material.shell.roughness"]
"#;

/// What every sweep begins with.
pub const HEAD: &str = "format = 1\ncapture = \"capture\"\n";

pub fn capture() -> Capture {
    Capture::parse(CAPTURE).unwrap()
}

/// The plan of a sweep that has these lines after its head, with a file beside it.
pub fn plan_of(capture: &Capture, lines: &str, list: &str) -> Result<Plan> {
    let files = MemoryFiles(BTreeMap::from([("list.csv".to_owned(), Arc::from(list.as_bytes()))]));
    Sweep::parse("sweep.toml", &format!("{HEAD}{lines}"), 10_000_000)?.plan(capture, &files)
}

/// The same, which must be right.
pub fn plan(lines: &str) -> Plan {
    plan_of(&capture(), lines, "").unwrap()
}

/// What its frames are called.
pub fn digests(plan: &Plan) -> Vec<FrameDigest> {
    plan.digests(&[("ball.ply".to_owned(), "aa".to_owned())], "1.0").unwrap()
}
