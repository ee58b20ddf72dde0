//! The camera of `--intrinsics`.

use super::refuse;
use crate::failure::Failure;
use crate::input::Input;
use gonio_scene::capture::{Camera, CameraOverride};
use std::path::Path;

/// The camera of a capture, or of the JSON object of an earlier calibration, for photos of `width` x `height` pixels.
///
/// # Errors
/// No such file, one without a camera or with several, or one for photos of another size.
pub(super) fn read(file: &Path, width: u32, height: u32) -> Result<Camera, Failure> {
    let at = format!("--intrinsics {}", file.display());
    let camera = if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        of_json(&at, file)?
    } else {
        let capture = Input::open(file)?.capture;
        if capture.photos.iter().any(|photo| photo.camera != CameraOverride::default()) {
            return Err(refuse(&at, "has photos of several cameras", "name a capture of one camera"));
        }
        capture.camera
    };
    if (camera.width, camera.height) != (width, height) {
        let problem =
            format!("is a camera of {} x {} pixels, the photos have {width} x {height}", camera.width, camera.height);
        return Err(refuse(&at, problem, "calibrate and locate unscaled photos of one camera"));
    }
    Ok(camera)
}

fn of_json(at: &str, file: &Path) -> Result<Camera, Failure> {
    let mend = "name what `gonio calibrate --json` wrote, or a capture.toml";
    let text = std::fs::read_to_string(file).map_err(|error| refuse(at, format!("cannot be read: {error}"), mend))?;
    let object: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| refuse(at, format!("is no JSON: {error}"), mend))?;
    let number = |key: &str| {
        let found = object["camera"][key].as_f64().filter(|x| x.is_finite());
        found.ok_or_else(|| refuse(at, format!("camera.{key} is no number"), mend))
    };
    let side = |key: &str| {
        let found = object["camera"][key].as_u64().and_then(|side| u32::try_from(side).ok());
        found.ok_or_else(|| refuse(at, format!("camera.{key} is no number of pixels"), mend))
    };
    let camera = Camera {
        width: side("width")?,
        height: side("height")?,
        fx: number("fx")?,
        fy: number("fy")?,
        cx: number("cx")?,
        cy: number("cy")?,
        distortion: [number("k1")?, number("k2")?, number("p1")?, number("p2")?, number("k3")?],
        ..Camera::default()
    };
    if !(camera.fx > 0.0 && camera.fy > 0.0) {
        return Err(refuse(at, "camera.fx and camera.fy must be above 0", mend));
    }
    Ok(camera)
}
