//! From one colour a pixel to three.

use super::{Demosaic, Sensor, refuse};
use gonio_scene::SceneError;
use rayon::prelude::*;

/// A sensor value from here on is clipped: white levels are stated to about this.
const CLIPPED: f32 = 0.995;

/// An image in the camera's channels, and which pixels have a clipped value in them.
pub(super) struct Planes {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[f32; 3]>,
    pub clipped: Vec<bool>,
}

/// Makes the three colours of every pixel.
///
/// # Errors
/// A mosaic with colours too far apart to be taken together.
pub(super) fn planes(file: &str, sensor: &Sensor, demosaic: Demosaic) -> Result<Planes, SceneError> {
    let Some((colours, columns)) = &sensor.mosaic else {
        let pixels: Vec<[f32; 3]> = sensor.values.as_chunks::<3>().0.to_vec();
        let clipped = pixels.iter().map(|pixel| pixel.iter().any(|value| *value >= CLIPPED)).collect();
        return Ok(Planes { width: sensor.width, height: sensor.height, pixels, clipped });
    };
    let rows = colours.len() / columns;
    let colour = |x: usize, y: usize| usize::from(colours[y % rows * columns + x % columns]);
    let (width, height) = (sensor.width, sensor.height);
    let value = |x: usize, y: usize| sensor.values[y * width + x];
    let made: Vec<([f32; 3], bool)>;
    let size;
    match demosaic {
        Demosaic::Superpixel => {
            let side = if *columns == 2 && rows == 2 { 2 } else { 3 };
            size = (width / side, height / side);
            let cell = |k: usize| {
                let (left, top) = (k % size.0 * side, k / size.0 * side);
                let places = (top..top + side).flat_map(|y| (left..left + side).map(move |x| (x, y, 1.0)));
                mean(places, colour, value)
            };
            made = (0..size.0 * size.1).into_par_iter().map(cell).collect();
        }
        Demosaic::Bilinear => {
            size = (width, height);
            // In a Bayer mosaic the nearest of another colour are one pixel off, in X-Trans up to two.
            let reach = if *columns == 2 && rows == 2 { 1 } else { 2 };
            let pixel = |k: usize| {
                let (x, y) = (k % width, k / width);
                let near = |at: usize, most: usize| at.saturating_sub(reach)..(at + reach + 1).min(most);
                let weight = |a: usize, b: usize| (reach + 1 - a.abs_diff(b)) as f32;
                let places = near(y, height)
                    .flat_map(|row| near(x, width).map(move |column| (column, row)))
                    .map(|(column, row)| (column, row, weight(column, x) * weight(row, y)));
                let (mut found, clipped) = mean(places, colour, value);
                // What a pixel measured itself stays as it is.
                found[colour(x, y)] = value(x, y);
                (found, clipped)
            };
            made = (0..width * height).into_par_iter().map(pixel).collect();
        }
    }
    if made.is_empty() || made.iter().any(|(pixel, _)| pixel.iter().any(|value| !value.is_finite())) {
        return Err(refuse(file, "has a mosaic of colours that is not known here"));
    }
    let (pixels, clipped) = made.into_iter().unzip();
    Ok(Planes { width: size.0, height: size.1, pixels, clipped })
}

/// The weighted mean of each colour over places (column, row, weight), and whether one of them is clipped.
fn mean(
    places: impl Iterator<Item = (usize, usize, f32)>,
    colour: impl Fn(usize, usize) -> usize,
    value: impl Fn(usize, usize) -> f32,
) -> ([f32; 3], bool) {
    let (mut sums, mut weights, mut clipped) = ([0.0; 3], [0.0; 3], false);
    for (x, y, weight) in places {
        let (c, v) = (colour(x, y), value(x, y));
        sums[c] += weight * v;
        weights[c] += weight;
        clipped |= v >= CLIPPED;
    }
    ([0, 1, 2].map(|c| sums[c] / weights[c]), clipped)
}
