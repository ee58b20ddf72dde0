//! COLMAP's text model: `cameras.txt` and `images.txt`.

use crate::geometry::Pose;
use crate::view::{Imported, View};
use gonio_scene::capture::Camera;
use gonio_scene::{Result, SceneError};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::collections::BTreeMap;

/// Reads both texts of a model. COLMAP's axes and pixel centres are those of the capture format; its poses map the world
/// to the camera and are turned round. The world's place, turn and scale are arbitrary.
///
/// # Errors
/// A malformed line, an unknown or fisheye camera model, an image of a camera that is not listed, no image at all.
pub fn colmap(cameras: &str, images: &str) -> Result<Imported> {
    let cameras = read_cameras(cameras)?;
    let file = "images.txt";
    let mut views = Vec::new();
    let mut lines = images.lines().enumerate().filter(|(_, line)| !line.starts_with('#'));
    while let Some((number, line)) = lines.next() {
        if line.trim().is_empty() {
            continue;
        }
        // The second line of an image lists its points, and may be empty.
        lines.next();
        let at = format!("line {}", number + 1);
        let wrong = |problem: &str| {
            let mend = "write IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, and the points on a line of their own";
            SceneError::new(file, problem, mend).at(&at)
        };
        let words: Vec<&str> = line.trim().splitn(10, char::is_whitespace).collect();
        let [_, pose @ .., camera, name] = words.as_slice() else { return Err(wrong("has too few words")) };
        let pose: Vec<f64> = pose.iter().filter_map(|word| word.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
        let [w, x, y, z, tx, ty, tz] = pose[..] else { return Err(wrong("is no quaternion and translation")) };
        let quaternion = Quaternion::new(w, x, y, z);
        if (quaternion.norm() - 1.0).abs() > 1e-2 {
            return Err(wrong("has a quaternion whose length is not 1"));
        }
        let rotation = UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix().into_inner();
        let camera = cameras
            .get(*camera)
            .ok_or_else(|| wrong(&format!("names camera {camera}, which cameras.txt does not list")))?;
        let world_to_camera = Pose { rotation, translation: Vector3::new(tx, ty, tz) };
        let camera_to_world = world_to_camera.inverse().matrix();
        views.push(View { file: (*name).trim().to_owned(), camera: camera.clone(), camera_to_world });
    }
    if views.is_empty() {
        return Err(SceneError::new(file, "lists no image", "name the folder of a reconstruction that holds images"));
    }
    let world = "COLMAP's world: its scale is arbitrary, so lengths here are no metres, and z need not point up";
    Ok(Imported { views, objects: Vec::new(), world })
}

fn read_cameras(text: &str) -> Result<BTreeMap<&str, Camera>> {
    let mut cameras = BTreeMap::new();
    for (number, line) in text.lines().enumerate() {
        if line.starts_with('#') || line.trim().is_empty() {
            continue;
        }
        let wrong = |problem: String, mend: &str| {
            SceneError::new("cameras.txt", problem, mend).at(format!("line {}", number + 1))
        };
        let mend = "write CAMERA_ID MODEL WIDTH HEIGHT and the model's parameters";
        let words: Vec<&str> = line.split_whitespace().collect();
        let [id, model, width, height, parameters @ ..] = words.as_slice() else {
            return Err(wrong("has too few words".to_owned(), mend));
        };
        let size = |word: &str| word.parse::<u32>().ok().filter(|&n| n > 0);
        let (Some(width), Some(height)) = (size(width), size(height)) else {
            return Err(wrong(format!("has the size {width} x {height}"), mend));
        };
        let p: Vec<f64> = parameters.iter().map(|word| word.parse().unwrap_or(f64::NAN)).collect();
        let (fx, fy, cx, cy, distortion) = match (*model, &p[..]) {
            ("SIMPLE_PINHOLE", &[f, cx, cy]) => (f, f, cx, cy, [0.0; 5]),
            ("PINHOLE", &[fx, fy, cx, cy]) => (fx, fy, cx, cy, [0.0; 5]),
            ("SIMPLE_RADIAL", &[f, cx, cy, k]) => (f, f, cx, cy, [k, 0.0, 0.0, 0.0, 0.0]),
            ("RADIAL", &[f, cx, cy, k1, k2]) => (f, f, cx, cy, [k1, k2, 0.0, 0.0, 0.0]),
            ("OPENCV", &[fx, fy, cx, cy, k1, k2, p1, p2]) => (fx, fy, cx, cy, [k1, k2, p1, p2, 0.0]),
            ("FULL_OPENCV", &[fx, fy, cx, cy, k1, k2, p1, p2, k3, 0.0, 0.0, 0.0]) => {
                (fx, fy, cx, cy, [k1, k2, p1, p2, k3])
            }
            _ => {
                let mend = "undistort the images by `colmap image_undistorter`, which gives a PINHOLE model";
                let problem = format!("is the model {model} with {} parameters, which has no equal here", p.len());
                return Err(wrong(problem, mend));
            }
        };
        if ![fx, fy].iter().all(|f| *f > 0.0 && f.is_finite()) || !p.iter().all(|x| x.is_finite()) {
            return Err(wrong(
                "has a parameter that is no number, or a focal length that is not positive".into(),
                mend,
            ));
        }
        cameras.insert(*id, Camera { width, height, fx, fy, cx, cy, distortion, ..Camera::default() });
    }
    Ok(cameras)
}
