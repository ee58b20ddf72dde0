//! COLMAP's models: the text of `cameras.txt` and `images.txt`, the bytes of `cameras.bin` and `images.bin`.

mod binary;
mod text;

pub use binary::colmap_binary;
pub use text::colmap;

use crate::geometry::Pose;
use crate::view::View;
use gonio_scene::capture::Camera;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

const WORLD: &str = "COLMAP's world: its scale is arbitrary, so lengths here are no metres, and z need not point up";

/// What is wrong with an entry, and how to mend it.
type Fault = (String, &'static str);

/// A camera of COLMAP's model `name` with the model's parameters `p`, size in pixels.
fn camera(name: &str, [width, height]: [u32; 2], p: &[f64]) -> Result<Camera, Fault> {
    let (fx, fy, cx, cy, distortion) = match (name, p) {
        ("SIMPLE_PINHOLE", &[f, cx, cy]) => (f, f, cx, cy, [0.0; 5]),
        ("PINHOLE", &[fx, fy, cx, cy]) => (fx, fy, cx, cy, [0.0; 5]),
        ("SIMPLE_RADIAL", &[f, cx, cy, k]) => (f, f, cx, cy, [k, 0.0, 0.0, 0.0, 0.0]),
        ("RADIAL", &[f, cx, cy, k1, k2]) => (f, f, cx, cy, [k1, k2, 0.0, 0.0, 0.0]),
        ("OPENCV", &[fx, fy, cx, cy, k1, k2, p1, p2]) => (fx, fy, cx, cy, [k1, k2, p1, p2, 0.0]),
        ("FULL_OPENCV", &[fx, fy, cx, cy, k1, k2, p1, p2, k3, 0.0, 0.0, 0.0]) => (fx, fy, cx, cy, [k1, k2, p1, p2, k3]),
        _ => {
            let mend = "undistort the images by `colmap image_undistorter`, which gives a PINHOLE model";
            return Err((format!("is the model {name} with {} parameters, which has no equal here", p.len()), mend));
        }
    };
    if ![fx, fy].iter().all(|f| *f > 0.0 && f.is_finite()) || !p.iter().all(|x| x.is_finite()) {
        let mend = "reconstruct anew, or correct the model's parameters";
        return Err(("has a parameter that is no number, or a focal length that is not positive".to_owned(), mend));
    }
    Ok(Camera { width, height, fx, fy, cx, cy, distortion, ..Camera::default() })
}

/// An image `file`, from its rotation as a quaternion w x y z and its translation, which map the world to the camera.
fn view(file: String, camera: &Camera, pose: [f64; 7]) -> Result<View, &'static str> {
    let [w, x, y, z, tx, ty, tz] = pose;
    let quaternion = Quaternion::new(w, x, y, z);
    if pose.iter().any(|number| !number.is_finite()) {
        return Err("has a pose that is no number");
    }
    if (quaternion.norm() - 1.0).abs() > 1e-2 {
        return Err("has a quaternion whose length is not 1");
    }
    let rotation = UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix().into_inner();
    let world_to_camera = Pose { rotation, translation: Vector3::new(tx, ty, tz) };
    Ok(View { file, camera: camera.clone(), camera_to_world: world_to_camera.inverse().matrix() })
}
