//! A photo's camera as Mitsuba's sensor.

use super::node::{Node, Value};
use crate::ledger::Ledger;
use crate::matrix::{diagonal, product};
use crate::scene::Scene;
use crate::view::{View, for_each_camera};
use gonio_scene::capture::Camera;

/// How the principal point may be off the image's centre, in parts of a pixel, before a lens cannot do with it.
const CENTRED: f64 = 1e-6;

/// The sensor of a photo: box filter, linear RGB. Mitsuba's camera looks along +z too, with x to the left and y up.
pub fn sensor(view: &View) -> Node {
    let camera = &view.camera;
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let degrees = 2.0 * libm::atan(width / 2.0 / camera.fx).to_degrees();
    let film = Node::new("film", "hdrfilm")
        .with("width", Value::Integer(camera.width.into()))
        .with("height", Value::Integer(camera.height.into()))
        .with("pixel_format", Value::Text("rgb"))
        .with("component_format", Value::Text("float32"))
        .with("rfilter", Value::Node(Node::new("rfilter", "box")));
    let sampler = Node::new("sampler", "independent").with("sample_count", Value::Integer(256));
    let kind = if camera.aperture_radius > 0.0 { "thinlens" } else { "perspective" };
    let mut sensor = Node::new("sensor", kind)
        .with("fov", Value::Number(degrees))
        .with("fov_axis", Value::Text("x"))
        .with("near_clip", Value::Number(0.001))
        .with("far_clip", Value::Number(10_000.0))
        .with("to_world", Value::Matrix(product(&view.pose, &diagonal([-1.0, -1.0, 1.0]))));
    if camera.aperture_radius > 0.0 {
        sensor = sensor
            .with("aperture_radius", Value::Number(camera.aperture_radius))
            .with("focus_distance", Value::Number(camera.focus_distance));
    } else {
        sensor = sensor
            .with("principal_point_offset_x", Value::Number((width / 2.0 - camera.cx) / width))
            .with("principal_point_offset_y", Value::Number((height / 2.0 - camera.cy) / height));
    }
    sensor.with("film", Value::Node(film)).with("sampler", Value::Node(sampler))
}

/// Judges the cameras' numbers.
pub fn judge(scene: &Scene<'_>, ledger: &mut Ledger) {
    for_each_camera(scene.capture, |name, camera| {
        let key = |key: &str| format!("{name}.{key}");
        ledger.exact(&key("fx"), "fov");
        if (camera.fy / camera.fx - 1.0).abs() < 1e-9 {
            ledger.exact(&key("fy"), "fov");
        } else {
            ledger.lost(&key("fy"), "Mitsuba's pixels are square: fx is used for both");
        }
        for (axis, offset) in [("cx", centre(camera)[0]), ("cy", centre(camera)[1])] {
            if camera.aperture_radius == 0.0 || offset < CENTRED {
                ledger.exact(&key(axis), "principal_point_offset");
            } else {
                ledger.lost(&key(axis), "Mitsuba's thinlens has its principal point in the image's centre");
            }
        }
        for lens in ["aperture_radius", "focus_distance"] {
            ledger.exact(&key(lens), if camera.aperture_radius > 0.0 { "thinlens" } else { "a pinhole" });
        }
        if camera.distortion == [0.0; 5] {
            ledger.exact(&key("distortion"), "not there");
        } else {
            ledger.lost(&key("distortion"), "Mitsuba's cameras do not distort");
        }
    });
}

/// How far the principal point lies from the centre, pixels.
fn centre(camera: &Camera) -> [f64; 2] {
    [camera.cx - f64::from(camera.width) / 2.0, camera.cy - f64::from(camera.height) / 2.0].map(f64::abs)
}
