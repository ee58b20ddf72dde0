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
/// No JSON, no frame, a key that is missing or of another kind, a matrix that is no rigid motion, a fisheye camera, an
/// image that `locate` does not find, or one that is no scaled form of what its camera states.
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
        let camera = camera(&Keys { file, top: &top, frame, index }, size)?;
        views.push(View { file: located, camera, camera_to_world: pose.matrix() });
    }
    let world = "the world of transforms.json: its scale is whatever made it, so lengths need not be metres";
    Ok(Imported { views, objects: Vec::new(), world })
}

/// The keys that belong together: where a frame has one of a group, all of the group is the frame's, as instant-ngp reads it
/// (`read_focal_length`, `read_lens` of its `nerf_loader`).
const GROUPS: [&[&str]; 4] = [
    &["fl_x", "fl_y", "camera_angle_x", "camera_angle_y"],
    &["cx", "cy"],
    &["w", "h"],
    &["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "camera_model", "is_fisheye"],
];

/// Where a camera's keys are looked up.
struct Keys<'v> {
    file: &'v str,
    top: &'v Value,
    frame: &'v Value,
    index: usize,
}

impl<'v> Keys<'v> {
    fn owner(&self, key: &str) -> &'v Value {
        let group = GROUPS.into_iter().find(|group| group.contains(&key)).unwrap_or_default();
        let own = group.iter().any(|key| self.frame.get(*key).is_some());
        if own { self.frame } else { self.top }
    }

    fn get(&self, key: &str) -> Option<&'v Value> {
        self.owner(key).get(key)
    }

    fn at(&self, key: &str) -> String {
        if std::ptr::eq(self.owner(key), self.frame) { format!("frames[{}].{key}", self.index) } else { key.to_owned() }
    }

    fn refuse(&self, key: &str, problem: impl Into<String>, mend: &str) -> SceneError {
        SceneError::new(self.file, problem, mend).at(self.at(key))
    }

    fn number(&self, key: &str) -> Result<Option<f64>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let number = value.as_f64().filter(|x| x.is_finite());
        number.map(Some).ok_or_else(|| self.refuse(key, "is no number", "write a number"))
    }
}

/// The frame's camera, for its image of `width` x `height` pixels.
fn camera(keys: &Keys<'_>, (width, height): (u32, u32)) -> Result<Camera> {
    let model = keys.get("camera_model").and_then(Value::as_str);
    let fisheye = keys.get("is_fisheye").and_then(Value::as_bool) == Some(true);
    let mut rational = false;
    for key in ["k4", "k5", "k6"] {
        rational |= keys.number(key)?.is_some_and(|k| k != 0.0);
    }
    let known = ["OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL"];
    if fisheye || rational || model.is_some_and(|model| !known.contains(&model)) {
        let mend = "undistort the images first: the capture format has pinholes with k1 k2 p1 p2 k3";
        return Err(keys.refuse("camera_model", "is a camera that has no equal here", mend));
    }
    // Intrinsics belong to the size that the file states; images may have been scaled since, but not cropped or turned.
    let (w, h) = (keys.number("w")?.unwrap_or(f64::from(width)), keys.number("h")?.unwrap_or(f64::from(height)));
    if !(w >= 1.0 && h >= 1.0) {
        return Err(keys.refuse("w", format!("is {w} x {h}"), "write the size in pixels"));
    }
    let (sx, sy) = (f64::from(width) / w, f64::from(height) / h);
    // A side that was scaled is rounded to whole pixels.
    if (h * sx - f64::from(height)).abs() > 1.0 && (w * sy - f64::from(width)).abs() > 1.0 {
        let problem = format!("is {w} x {h}, its image {width} x {height}: it was cropped or turned, not scaled");
        return Err(keys.refuse(
            "w",
            problem,
            "give the images that the poses were estimated from, or their own cameras",
        ));
    }
    let from_angle = |angle: Option<f64>, size: f64| angle.map(|a| 0.5 * size / libm::tan(0.5 * a));
    let fx = match keys.number("fl_x")? {
        Some(f) => Some(f),
        None => from_angle(keys.number("camera_angle_x")?, w),
    };
    let fx = fx.filter(|f| f.is_finite() && *f > 0.0).ok_or_else(|| {
        let mend = "write fl_x in pixels, or camera_angle_x in radians";
        keys.refuse("fl_x", "is missing or not positive", mend)
    })?;
    let fy = match keys.number("fl_y")? {
        Some(f) => f,
        None => from_angle(keys.number("camera_angle_y")?, h).unwrap_or(fx),
    };
    if !(fy.is_finite() && fy > 0.0) {
        return Err(keys.refuse("fl_y", "is not positive", "write fl_y in pixels"));
    }
    let mut distortion = [0.0; 5];
    for (value, key) in distortion.iter_mut().zip(["k1", "k2", "p1", "p2", "k3"]) {
        *value = keys.number(key)?.unwrap_or(0.0);
    }
    let (cx, cy) = (keys.number("cx")?.unwrap_or(w / 2.0), keys.number("cy")?.unwrap_or(h / 2.0));
    let camera = Camera { width, height, distortion, ..Camera::default() };
    Ok(Camera { fx: fx * sx, fy: fy * sy, cx: cx * sx, cy: cy * sy, ..camera })
}
