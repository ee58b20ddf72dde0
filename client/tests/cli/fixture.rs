//! A small capture of two objects, made by the test itself, and the binary that works on it.

use gonio_scene::Capture;
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::{Image, write_exr, write_png8};
use gonio_scene::mesh::{Mesh, write_ply};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// Width and height of the photos.
pub const SIZE: (u32, u32) = (32, 24);

/// What the photographs are rendered with.
pub const TRUTH: Values = Values { color: [0.6, 0.35, 0.2], roughness: 0.35, intensity: 0.3 };
/// Where a fit starts.
pub const START: Values = Values { color: [0.5, 0.5, 0.5], roughness: 0.5, intensity: 0.2 };

/// The numbers that a fit frees.
#[derive(Clone, Copy)]
pub struct Values {
    pub color: [f64; 3],
    pub roughness: f64,
    pub intensity: f64,
}

/// Runs `gonio` in the folder `at`.
pub fn gonio(at: &Path, arguments: &[&str]) -> Output {
    command(at, arguments).output().unwrap()
}

pub fn command(at: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gonio"));
    command.current_dir(at).args(arguments).env_remove("RUST_LOG");
    command
}

/// Runs `gonio`, which must succeed; returns its standard output.
pub fn succeeds(at: &Path, arguments: &[&str]) -> String {
    let output = gonio(at, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {stderr}");
    assert!(!stderr.contains("panicked"), "{stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs `gonio`, which must refuse its input in plain words that contain all of `says`.
pub fn refused(at: &Path, arguments: &[&str], says: &[&str]) {
    let output = gonio(at, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert!(!stderr.contains("panicked"), "{stderr}");
    assert!(stderr.lines().any(|line| line.starts_with("error: ")), "{arguments:?}: {stderr}");
    for text in says {
        assert!(stderr.contains(text), "{arguments:?}: no \"{text}\" in: {stderr}");
    }
}

/// The JSON object that is all of a command's standard output.
pub fn json(stdout: &str) -> serde_json::Value {
    assert_eq!(stdout.trim_end().lines().count(), 1, "{stdout}");
    serde_json::from_str(stdout).unwrap()
}

/// A capture without photographs, in `capture` below a new folder.
pub fn scene(values: Values) -> TempDir {
    let top = tempfile::tempdir().unwrap();
    let root = top.path().join("capture");
    std::fs::create_dir(&root).unwrap();
    std::fs::write(root.join("ball.ply"), write_ply(&ball())).unwrap();
    std::fs::write(root.join("board.ply"), write_ply(&board())).unwrap();
    std::fs::write(root.join("capture.toml"), toml(values)).unwrap();
    top
}

/// The same with photographs that `gonio render` made at the truth, starting from elsewhere.
pub fn photographed(samples: u32) -> TempDir {
    let top = scene(TRUTH);
    let samples = samples.to_string();
    succeeds(top.path(), &["render", "capture", "--out", "capture/photos", "--samples", &samples, "--seed", "99"]);
    std::fs::write(top.path().join("capture/capture.toml"), toml(START)).unwrap();
    top
}

/// The same with photographs of one gray, for what never gets as far as rendering.
pub fn gray() -> TempDir {
    let top = scene(START);
    let photos = top.path().join("capture/photos");
    std::fs::create_dir(&photos).unwrap();
    let (width, height) = SIZE;
    let image = Image { width, height, pixels: vec![[0.25; 3]; (width * height) as usize] };
    for name in ["00.exr", "01.exr", "02.exr", "03.exr"] {
        write_exr(&photos.join(name), &image).unwrap();
    }
    write_png8(&photos.join("mask.png"), width, height, &vec![[255; 3]; (width * height) as usize]).unwrap();
    top
}

/// The same under a sky, in photo 01 and in the held-out photo 03, that is brighter than a float32 can tell.
pub fn blinded(top: TempDir) -> TempDir {
    let sky = Image { width: 4, height: 2, pixels: vec![[1e30; 3]; 8] };
    write_exr(&top.path().join("capture/sky.exr"), &sky).unwrap();
    let light = "\n[[light]]\nname = \"blast\"\nkind = \"environment\"\nmap = \"sky.exr\"\nscale = 1e12\n\n[fit]\n";
    edit(&capture_file(&top), "\n[fit]\n", light);
    for (photo, blast) in ["", ", \"blast\"", "", ", \"blast\""].iter().enumerate() {
        let file = format!("file = \"photos/0{photo}.exr\"\n");
        edit(&capture_file(&top), &file, &format!("{file}lights = [\"led\"{blast}]\n"));
    }
    top
}

/// Writes a photo of one gray.
pub fn gray_png(file: &Path, width: u32, height: u32) {
    write_png8(file, width, height, &vec![[90; 3]; (width * height) as usize]).unwrap();
}

/// The capture in a folder.
pub fn capture(at: &Path) -> Capture {
    Capture::read(&DirectoryFiles::new(at)).unwrap()
}

/// Replaces `from`, which must be there, in the text file `path`.
pub fn edit(path: &Path, from: &str, to: &str) {
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{from} is not in {}", path.display());
    std::fs::write(path, text.replace(from, to)).unwrap();
}

pub fn capture_file(top: &TempDir) -> PathBuf {
    top.path().join("capture/capture.toml")
}

fn toml(values: Values) -> String {
    let Values { color, roughness, intensity } = values;
    let (width, height) = SIZE;
    let mut text = format!(
        r#"format = 1
name = "ball on a board"

[camera]
width = {width}
height = {height}
fx = 48.0
fy = 48.0
cx = 16.0
cy = 12.0

[sensor]
read_noise = 0.002
shot_noise = 0.0002

[[material]]
name = "shell"
model = "plastic"
base_color = {color:?}
roughness = {roughness:?}
ior = 1.5

[[material]]
name = "paint"
model = "lambert"
base_color = [0.7, 0.7, 0.7]

[[object]]
name = "ball"
mesh = "ball.ply"
material = "shell"
object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.05], [0, 0, 0, 1]]

[[object]]
name = "board"
mesh = "board.ply"
material = "paint"
object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]

[[light]]
name = "led"
kind = "point"
frame = "camera"
position = [0.05, 0.0, 0.0]
intensity = [{intensity:?}, {intensity:?}, {intensity:?}]

[fit]
parameters = ["material.shell.base_color", "material.shell.roughness", "light.led.intensity"]
gray = ["light.led.intensity"]
"#
    );
    for (i, (azimuth, elevation)) in [(0.3, 0.9), (2.2, 0.6), (4.4, 1.1), (5.5, 0.8)].into_iter().enumerate() {
        let role = if i == 3 { "held-out" } else { "fit" };
        let pose = pose(azimuth, elevation, 0.4);
        text += &format!("\n[[photo]]\nfile = \"photos/0{i}.exr\"\nrole = \"{role}\"\ncamera_to_world = {pose:?}\n");
    }
    text
}

/// A camera that looks at the ball from a distance, upright.
fn pose(azimuth: f64, elevation: f64, distance: f64) -> [[f64; 4]; 4] {
    let ((sa, ca), (se, ce)) = (azimuth.sin_cos(), elevation.sin_cos());
    let (right, down, forward) = ([-sa, ca, 0.0], [ca * se, sa * se, -ce], [-ca * ce, -sa * ce, -se]);
    let eye = [-forward[0] * distance, -forward[1] * distance, 0.05 - forward[2] * distance];
    let row = |i: usize| [right[i], down[i], forward[i], eye[i]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

pub fn ball() -> Mesh {
    let (rings, segments) = (16_u32, 32_u32);
    let mut mesh = Mesh { normals: Some(Vec::new()), ..Mesh::default() };
    for i in 0..=rings {
        for j in 0..segments {
            let (st, ct) = (PI * f64::from(i) / f64::from(rings)).sin_cos();
            let (sp, cp) = (2.0 * PI * f64::from(j) / f64::from(segments)).sin_cos();
            let normal = [st * cp, st * sp, ct].map(|x| x as f32);
            mesh.positions.push(normal.map(|x| 0.05 * x));
            mesh.normals.as_mut().unwrap().push(normal);
        }
    }
    for i in 0..rings {
        for j in 0..segments {
            let at = |i: u32, j: u32| i * segments + j % segments;
            if i > 0 {
                mesh.triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            }
            if i + 1 < rings {
                mesh.triangles.push([at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)]);
            }
        }
    }
    mesh
}

fn board() -> Mesh {
    let side = 0.2;
    Mesh {
        positions: vec![[-side, -side, 0.0], [side, -side, 0.0], [side, side, 0.0], [-side, side, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}
