//! Lamps and cameras that stand inside of an object.

use super::placed::{Placed, eye};
use super::vector::{Vector, add};
use gonio_scene::Capture;
use gonio_scene::capture::{Frame, LightKind, Photo};

/// Warns of every light and camera that a closed surface holds: its outside is all that is seen and lit.
pub(super) fn warn(placed: &Placed<'_>, capture: &Capture, warnings: &mut Vec<String>) {
    let name = &placed.object.name;
    let (low, high) = placed.bounds();
    let largest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let large = format!("which is {largest:.3} m large; is its pose right, and is its mesh in metres?");
    let cameras: Vec<&str> = capture.photos.iter().filter(|photo| placed.holds(eye(photo))).map(Photo::name).collect();
    if let [first, others @ ..] = cameras.as_slice() {
        let more = if others.is_empty() { String::new() } else { format!(" and {} more", others.len()) };
        warnings.push(format!(
            "capture.toml: photo.{first}.camera_to_world: the camera{more} stands inside of object {name}, {large}"
        ));
    }
    for light in &capture.lights {
        let (LightKind::Point { position, .. } | LightKind::Sphere { position, .. }) = &light.kind else { continue };
        let on = |names: &Option<Vec<String>>| names.as_ref().is_none_or(|names| names.contains(&light.name));
        let inside = if light.frame == Frame::World {
            placed.holds(*position)
        } else {
            let stands = |photo: &Photo| {
                let pose = photo.pose();
                let turned: Vector = std::array::from_fn(|i| (0..3).map(|j| pose[i][j] * position[j]).sum());
                add(turned, eye(photo))
            };
            // A lamp at the camera is inside where the camera is, which has been said.
            capture.photos.iter().filter(|p| on(&p.lights) && !placed.holds(eye(p))).any(|p| placed.holds(stands(p)))
        };
        if inside {
            let lamp = &light.name;
            warnings.push(format!("capture.toml: light.{lamp}.position: lies inside of object {name}, {large}"));
        }
    }
}
