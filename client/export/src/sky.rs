//! Environment maps.

use crate::Result;
use crate::files::FileMap;
use crate::scene::Scene;
use gonio_scene::image::{Image, encode_exr};
use std::sync::Arc;

/// A map of the capture, and where it goes.
pub struct Map {
    /// The file of the export.
    pub file: String,
    pub image: Arc<Image>,
}

/// Every map as OpenEXR: equirectangular, the centre column along +x of its frame, the top row along +z.
///
/// # Errors
/// An image without pixels.
pub fn files(scene: &Scene<'_>) -> Result<FileMap> {
    let encode = |map: &Map| Ok((map.file.clone(), encode_exr(&map.file, &map.image)?));
    scene.maps.values().map(encode).collect()
}

/// The radiance of a map in a unit direction of its frame, as Gonio takes it: rows are nodes from zenith to nadir, columns
/// wrap, bilinear in between.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // Below 2^24, not negative.
pub fn radiance(image: &Image, [x, y, z]: [f64; 3]) -> [f64; 3] {
    use std::f64::consts::PI;
    let (width, height) = (image.width as usize, image.height as usize);
    let down = libm::acos(z.clamp(-1.0, 1.0)) / PI * (height.saturating_sub(1)) as f64;
    let right = (0.5 - libm::atan2(y, x) / (2.0 * PI)) * width as f64 - 0.5;
    let right = if right < 0.0 { right + width as f64 } else { right };
    let (i, j) = ((down as usize).min(height.saturating_sub(2)), (right as usize).min(width - 1));
    let (down, right) = (down - i as f64, right - j as f64);
    let node = |i: usize, j: usize, c: usize| f64::from(image.pixels[i.min(height - 1) * width + j % width][c]);
    [0, 1, 2].map(|c| {
        let row = |i: usize| node(i, j, c) * (1.0 - right) + node(i, j + 1, c) * right;
        row(i) * (1.0 - down) + row(i + 1) * down
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_column_looks_along_x_and_the_quarter_to_its_left_along_y() {
        let (width, height) = (8, 5);
        let pixels = (0..width * height).map(|k| [(k % width) as f32, (k / width) as f32, 1.0]).collect();
        let image = Image { width, height, pixels };
        let close = |found: [f64; 3], expected: [f64; 3]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {expected:?}");
        };
        close(radiance(&image, [1.0, 0.0, 0.0]), [3.5, 2.0, 1.0]);
        close(radiance(&image, [0.0, 1.0, 0.0]), [1.5, 2.0, 1.0]);
        close(radiance(&image, [0.0, -1.0, 0.0]), [5.5, 2.0, 1.0]);
        assert!((radiance(&image, [0.0, 0.0, 1.0])[1]).abs() < 1e-9);
        assert!((radiance(&image, [0.0, 0.0, -1.0])[1] - 4.0).abs() < 1e-9);
        // Behind, the columns wrap.
        close(radiance(&image, [-1.0, 0.0, 0.0]), [3.5, 2.0, 1.0]);
    }
}
