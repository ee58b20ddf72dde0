//! A frame in small, as its record keeps it: enough to show it, whatever the brightness that is chosen later.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gonio_scene::Film;
use gonio_scene::capture::Response;
use serde::{Deserialize, Serialize};

/// The longer side of a thumbnail in pixels.
const SIDE: u32 = 96;

/// Linear RGB in small.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Thumbnail {
    /// Pixels, at most 96.
    pub width: u32,
    /// Pixels, at most 96.
    pub height: u32,
    /// The largest value, which 255 stands for.
    scale: f64,
    /// Whether values still need a curve to be looked at: those of a sensor with a linear response.
    linear: bool,
    /// base64 of `height * width * 3` bytes; a byte b stands for `scale * (b / 255)^2`, which keeps dark values apart.
    pixels: String,
}

/// Pixels of a frame, along each side, that become one.
fn factor(width: u32, height: u32) -> u32 {
    width.max(height).div_ceil(SIDE).max(1)
}

impl Thumbnail {
    /// Width and height of the thumbnail of a frame.
    #[must_use]
    pub fn size(width: u32, height: u32) -> (u32, u32) {
        let factor = factor(width, height);
        (width.div_ceil(factor), height.div_ceil(factor))
    }

    /// Gives its pixels' memory back.
    pub fn forget(&mut self) {
        self.pixels = String::new();
    }

    /// A film of photo values in small: means over equal squares.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn of(film: &Film, response: &Response) -> Self {
        let factor = factor(film.width, film.height);
        let (width, height) = Self::size(film.width, film.height);
        let mut values = Vec::with_capacity(3 * (width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                let rows = y * factor..film.height.min((y + 1) * factor);
                let columns = x * factor..film.width.min((x + 1) * factor);
                let count = f64::from(rows.len() as u32) * f64::from(columns.len() as u32);
                for channel in 0..3 {
                    let at = |row: u32, column: u32| {
                        let index = row as usize * film.width as usize + column as usize;
                        film.channels.get(channel).and_then(|c| c.get(index)).map_or(0.0, |v| f64::from(*v))
                    };
                    let sum: f64 =
                        rows.clone().flat_map(|r| columns.clone().map(move |c| (r, c))).map(|(r, c)| at(r, c)).sum();
                    values.push(sum / count);
                }
            }
        }
        let scale = values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
        let byte = |value: &f64| {
            let part = if scale > 0.0 { (value / scale).clamp(0.0, 1.0) } else { 0.0 };
            (255.0 * part.sqrt()).round() as u8
        };
        let bytes: Vec<u8> = values.iter().map(byte).collect();
        Self { width, height, scale, linear: response.is_linear(), pixels: STANDARD.encode(bytes) }
    }

    /// Whether values still need a curve to be looked at.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        self.linear
    }

    /// Its photo values, row by row; black where the record holds another number of bytes than its size says.
    #[must_use]
    pub fn values(&self) -> Vec<[f64; 3]> {
        let count = self.width.min(SIDE) as usize * self.height.min(SIDE) as usize;
        let bytes = STANDARD.decode(&self.pixels).unwrap_or_default();
        let value = |b: u8| self.scale * (f64::from(b) / 255.0) * (f64::from(b) / 255.0);
        let mut values: Vec<[f64; 3]> =
            bytes.chunks_exact(3).map(|p| [value(p[0]), value(p[1]), value(p[2])]).collect();
        values.resize(count, [0.0; 3]);
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_films_keep_their_pixels_and_large_ones_their_means() {
        let film = |width: u32, height: u32, value: fn(u32) -> f32| Film {
            width,
            height,
            channels: vec![(0..width * height).map(value).collect(); 3],
            ..Film::default()
        };
        let small = Thumbnail::of(&film(8, 4, |i| i as f32), &Response::Linear);
        assert_eq!((small.width, small.height), (8, 4));
        for (i, value) in small.values().iter().enumerate() {
            // One step of a byte near v is 2 sqrt(v scale) / 255.
            assert!((value[1] - i as f64).abs() <= (i as f64 * 31.0).sqrt() / 255.0 + 1e-3, "{i}: {value:?}");
        }
        let large = Thumbnail::of(&film(300, 200, |i| if i % 2 == 0 { 1.0 } else { 3.0 }), &Response::Srgb);
        assert_eq!((large.width, large.height, large.is_linear()), (75, 50, false));
        assert!(large.values().iter().flatten().all(|v| (v - 2.0).abs() < 1e-12));
        let dark = Thumbnail::of(&film(2, 2, |_| -1.0), &Response::Linear);
        assert_eq!(dark.values(), [[0.0; 3]; 4]);
    }
}
