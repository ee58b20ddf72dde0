//! An equirectangular map turned and levelled.

use gonio_scene::SceneError;
use gonio_scene::image::Image;
use nalgebra::{Rotation3, Vector3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// How a camera stood, degrees.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Orientation {
    /// What lies this far to the right of the middle column comes to the middle.
    pub turn: f64,
    /// How far the camera's front was tilted up: the horizon is brought back to the middle row there.
    pub pitch: f64,
    /// How far the camera was rolled clockwise as it looks ahead.
    pub roll: f64,
}

/// Resamples an equirectangular `map` (twice as wide as high, the top row straight up, the front in the middle column) as a
/// level camera would have seen it; bilinear.
///
/// # Errors
/// The map is not twice as wide as high.
pub fn orient(file: &str, map: &Image, orientation: Orientation) -> Result<Image, SceneError> {
    check(file, map, "turn")?;
    let angle = |degrees: f64| degrees.to_radians();
    // x ahead, y to the right, z up: where the camera saw what a level camera sees in a direction.
    let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), angle(orientation.turn));
    let pitched = Rotation3::from_axis_angle(&Vector3::y_axis(), angle(orientation.pitch));
    let rolled = Rotation3::from_axis_angle(&Vector3::x_axis(), angle(orientation.roll));
    let rotation = rolled * pitched * turned;
    let (width, height) = (map.width as usize, map.height as usize);
    let pixels = (0..width * height)
        .into_par_iter()
        .map(|pixel| {
            let azimuth = ((pixel % width) as f64 + 0.5) / width as f64 * TAU - PI;
            let elevation = FRAC_PI_2 - ((pixel / width) as f64 + 0.5) / height as f64 * PI;
            let ((sin, cos), (rise, along)) = (libm::sincos(azimuth), libm::sincos(elevation));
            let seen = rotation * Vector3::new(along * cos, along * sin, rise);
            let column = (libm::atan2(seen.y, seen.x) + PI) / TAU * width as f64 - 0.5;
            let row = (FRAC_PI_2 - libm::asin(seen.z.clamp(-1.0, 1.0))) / PI * height as f64 - 0.5;
            bilinear(map, column, row)
        })
        .collect();
    Ok(Image { width: map.width, height: map.height, pixels })
}

/// Refuses a map that is not equirectangular; `key` names the option that wants one.
pub(super) fn check(file: &str, map: &Image, key: &str) -> Result<(), SceneError> {
    if map.width == 2 * map.height && map.height > 0 {
        return Ok(());
    }
    let problem =
        format!("is {} x {} pixels, and an equirectangular map is twice as wide as high", map.width, map.height);
    Err(SceneError::new(file, problem, "leave --turn, --level and --fill-below away, or give full panoramas").at(key))
}

/// A value between pixels: round the columns, clamped at the poles.
fn bilinear(map: &Image, column: f64, row: f64) -> [f32; 3] {
    let (width, height) = (i64::from(map.width), i64::from(map.height));
    let (x, y) = (column.floor(), row.clamp(0.0, height as f64 - 1.0).floor());
    let (fx, fy) = ((column - x) as f32, (row.clamp(0.0, height as f64 - 1.0) - y) as f32);
    let at = |dx: i64, dy: i64| {
        let column = (x as i64 + dx).rem_euclid(width);
        let row = (y as i64 + dy).min(height - 1);
        map.pixels[(row * width + column) as usize]
    };
    let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
    std::array::from_fn(|k| {
        let (top, bottom) = (a[k] + fx * (b[k] - a[k]), c[k] + fx * (d[k] - c[k]));
        top + fy * (bottom - top)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smooth() -> Image {
        let pixels = (0..128 * 64).map(|k| {
            let (x, y) = ((f64::from(k % 128) + 0.5) / 128.0 * TAU, (f64::from(k / 128) + 0.5) / 64.0 * PI);
            let around = libm::sin(y) as f32;
            [2.0 + around * libm::cos(x) as f32, 2.0 + around * libm::sin(x) as f32, 2.0 + libm::cos(y) as f32]
        });
        Image { width: 128, height: 64, pixels: pixels.collect() }
    }

    #[test]
    fn a_turn_moves_columns_and_a_tilt_is_undone_by_its_opposite() -> Result<(), SceneError> {
        let map = smooth();
        let turned = orient("map", &map, Orientation { turn: 90.0, ..Orientation::default() })?;
        assert!((turned.pixels[64 + 128 * 20][0] - map.pixels[96 + 128 * 20][0]).abs() < 1e-3);
        let there = orient("map", &map, Orientation { pitch: 20.0, ..Orientation::default() })?;
        let back = orient("map", &there, Orientation { pitch: -20.0, ..Orientation::default() })?;
        let worst = map.pixels.iter().zip(&back.pixels).map(|(a, b)| (a[2] - b[2]).abs()).fold(0.0, f32::max);
        assert!(worst < 0.01, "{worst}");
        // The front was tilted up: what it saw in the middle, the level camera sees 20 degrees above the horizon.
        let above = ((90.0 - 20.0) / 180.0 * 64.0) as usize;
        assert!((there.pixels[64 + 128 * above][2] - map.pixels[64 + 128 * 32][2]).abs() < 0.06);
        // A camera that leans to its right sees the zenith to its left, and what is level on its right above its horizon.
        let mut leaning = Image { width: 128, height: 64, pixels: vec![[0.0; 3]; 128 * 64] };
        let row = ((90.0 - 60.0) / 180.0 * 64.0) as usize;
        for k in [row * 128 + 31, row * 128 + 32, (row + 1) * 128 + 31, (row + 1) * 128 + 32] {
            leaning.pixels[k] = [1.0; 3];
        }
        let level = orient("map", &leaning, Orientation { roll: 30.0, ..Orientation::default() })?;
        let brightest = (0..128 * 64).max_by(|&a, &b| level.pixels[a][0].total_cmp(&level.pixels[b][0]));
        assert!(brightest.is_some_and(|k| k < 3 * 128), "{brightest:?}");
        assert!(
            orient("map", &Image { width: 3, height: 3, pixels: vec![[0.0; 3]; 9] }, Orientation::default()).is_err()
        );
        Ok(())
    }
}
