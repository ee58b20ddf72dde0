//! The same views with more or fewer pixels.

use gonio_scene::capture::{Camera, CameraOverride};
use gonio_scene::{Capture, MAX_SIDE, Result, SceneError};

/// Scales every camera of `capture` to `factor` of its width and height, in whole pixels: what a pixel showed moves to
/// the corresponding place. Glare keeps its size on the sensor.
///
/// # Errors
/// A camera with more pixels a side than the farm renders.
pub(crate) fn scale(capture: &mut Capture, factor: f64, file: &str) -> Result<()> {
    if factor == 1.0 {
        return Ok(());
    }
    let whole = scaled(&capture.camera, factor);
    for photo in &mut capture.photos {
        if photo.camera != CameraOverride::default() {
            // Of its own size: the rounding to whole pixels is its own, too, so all of its keys are.
            let own = scaled(&photo.camera.over(&capture.camera), factor);
            photo.camera = CameraOverride {
                width: Some(own.width),
                height: Some(own.height),
                fx: Some(own.fx),
                fy: Some(own.fy),
                cx: Some(own.cx),
                cy: Some(own.cy),
                glare_width: Some(own.glare_width),
                ..photo.camera.clone()
            };
        }
    }
    capture.camera = whole;
    let largest = capture.photos.iter().map(|photo| capture.camera_of(photo)).map(|c| c.width.max(c.height)).max();
    if largest.is_some_and(|side| side > MAX_SIDE) {
        let problem = format!("is {factor}, which makes images larger than {MAX_SIDE} pixels a side");
        return Err(SceneError::new(file, problem, "write a smaller one").at("resolution"));
    }
    Ok(())
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn scaled(camera: &Camera, factor: f64) -> Camera {
    let side = |pixels: u32| (f64::from(pixels) * factor).round().max(1.0) as u32;
    let (width, height) = (side(camera.width), side(camera.height));
    let (x, y) = (f64::from(width) / f64::from(camera.width), f64::from(height) / f64::from(camera.height));
    Camera {
        width,
        height,
        fx: camera.fx * x,
        fy: camera.fy * y,
        cx: camera.cx * x,
        cy: camera.cy * y,
        glare_width: camera.glare_width * x,
        ..camera.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::capture::Photo;

    #[test]
    fn what_is_seen_stays_the_same() {
        let camera = Camera { width: 160, height: 121, fx: 200.0, fy: 210.0, cx: 80.0, cy: 60.0, ..Camera::default() };
        let narrow = CameraOverride { width: Some(81), fx: Some(100.0), ..CameraOverride::default() };
        let photos = vec![Photo::default(), Photo { camera: narrow, ..Photo::default() }];
        let before = Capture { camera, photos, ..Capture::default() };
        let mut after = before.clone();
        scale(&mut after, 0.25, "sweep.toml").unwrap();
        for (was, is) in before.photos.iter().zip(&after.photos) {
            let (was, is) = (before.camera_of(was), after.camera_of(is));
            assert_eq!(is.width, (f64::from(was.width) * 0.25).round() as u32);
            // The directions of the four edges.
            let tan = |edge: f64, c: f64, f: f64| (edge - c) / f;
            for part in [0.0, 1.0] {
                let (a, b) = (part * f64::from(was.width), part * f64::from(is.width));
                assert!((tan(a, was.cx, was.fx) - tan(b, is.cx, is.fx)).abs() < 1e-12);
                let (a, b) = (part * f64::from(was.height), part * f64::from(is.height));
                assert!((tan(a, was.cy, was.fy) - tan(b, is.cy, is.fy)).abs() < 1e-12);
            }
        }
        assert!(scale(&mut after, 1e6, "sweep.toml").unwrap_err().to_string().contains("resolution"));
    }
}
