//! `transforms.json` of NeRF, instant-ngp and nerfstudio.

use crate::geometry::Pose;
use crate::json::{numbers, parse};
use crate::view::{Imported, Located, View};
use gonio_scene::capture::Camera;
use gonio_scene::{Result, SceneError};
use serde_json::Value;

/// Reads the text of `file`. Its cameras look along -z with y up (OpenGL): the second and third column change sign.
/// `locate` finds an image by its `file_path`, which may lack the extension, and gives its path and size in pixels.
///
/// # Errors
/// No JSON, no frame, a key that is missing or of another kind, a matrix that is no rigid motion, a fisheye camera, or an
/// image that `locate` does not find.
pub fn transforms(file: &str, text: &str, locate: &dyn Fn(&str) -> Located) -> Result<Imported> {
    let top = parse(file, text)?;
    let frames = top.get("frames").and_then(Value::as_array).filter(|frames| !frames.is_empty());
    let frames = frames.ok_or_else(|| {
        SceneError::new(file, "is missing or empty", "name a transforms.json that lists frames").at("frames")
    })?;
    let mut views = Vec::new();
    for (index, frame) in frames.iter().enumerate() {
        let at = |key: &str| format!("frames[{index}].{key}");
        let path = frame.get("file_path").and_then(Value::as_str).ok_or_else(|| {
            SceneError::new(file, "is missing or no text", "write the image's path").at(at("file_path"))
        })?;
        let (located, size) = locate(path).map_err(|error| error.at(at("file_path")))?;
        let key = at("transform_matrix");
        let m: [f64; 16] = numbers(file, &key, frame.get("transform_matrix").unwrap_or(&Value::Null))?;
        let rows = [m[0], -m[1], -m[2], m[4], -m[5], -m[6], m[8], -m[9], -m[10]];
        let pose = Pose::new(&rows, [m[3], m[7], m[11]]).ok_or_else(|| {
            let mend = "write a rotation and a translation, camera to world, row-major";
            SceneError::new(file, "is no rigid motion", mend).at(&key)
        })?;
        let camera = camera(file, &top, frame, size)?;
        views.push(View { file: located, camera, camera_to_world: pose.matrix() });
    }
    let world = "the world of transforms.json: its scale is whatever made it, so lengths need not be metres";
    Ok(Imported { views, objects: Vec::new(), world })
}

/// A frame's own keys go before those of the whole file.
fn camera(file: &str, top: &Value, frame: &Value, (width, height): (u32, u32)) -> Result<Camera> {
    let get = |key: &str| -> Result<Option<f64>> {
        let Some(value) = frame.get(key).or_else(|| top.get(key)) else { return Ok(None) };
        let number = value.as_f64().filter(|x| x.is_finite());
        number.map(Some).ok_or_else(|| SceneError::new(file, "is no number", "write a number").at(key))
    };
    let model = frame.get("camera_model").or_else(|| top.get("camera_model")).and_then(Value::as_str);
    let fisheye = ["is_fisheye"].iter().any(|key| top.get(key).and_then(Value::as_bool) == Some(true));
    if fisheye
        || get("k4")?.is_some_and(|k| k != 0.0)
        || model.is_some_and(|m| !["OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL"].contains(&m))
    {
        let mend = "undistort the images first: the capture format has pinholes with k1 k2 p1 p2 k3";
        return Err(SceneError::new(file, "is a camera that has no equal here", mend).at("camera_model"));
    }
    // Intrinsics belong to the size that the file states; images may have been scaled since.
    let (w, h) = (get("w")?.unwrap_or(f64::from(width)), get("h")?.unwrap_or(f64::from(height)));
    if !(w >= 1.0 && h >= 1.0) {
        return Err(SceneError::new(file, format!("is {w} x {h}"), "write the size in pixels").at("w"));
    }
    let (sx, sy) = (f64::from(width) / w, f64::from(height) / h);
    let from_angle = |angle: Option<f64>, size: f64| angle.map(|a| 0.5 * size / libm::tan(0.5 * a));
    let fx = match get("fl_x")? {
        Some(f) => Some(f),
        None => from_angle(get("camera_angle_x")?, w),
    };
    let fx = fx.filter(|f| f.is_finite() && *f > 0.0).ok_or_else(|| {
        let mend = "write fl_x in pixels, or camera_angle_x in radians";
        SceneError::new(file, "is missing or not positive", mend).at("fl_x")
    })?;
    let fy = match get("fl_y")? {
        Some(f) => f,
        None => from_angle(get("camera_angle_y")?, h).unwrap_or(fx),
    };
    let mut distortion = [0.0; 5];
    for (value, key) in distortion.iter_mut().zip(["k1", "k2", "p1", "p2", "k3"]) {
        *value = get(key)?.unwrap_or(0.0);
    }
    let (cx, cy) = (get("cx")?.unwrap_or(w / 2.0), get("cy")?.unwrap_or(h / 2.0));
    let camera = Camera { width, height, distortion, ..Camera::default() };
    Ok(Camera { fx: fx * sx, fy: fy * sy, cx: cx * sx, cy: cy * sy, ..camera })
}
