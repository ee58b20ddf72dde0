//! A view cut out of its background, at the size at which it is shown.

use gonio_scene::SceneError;
use gonio_scene::image::Image;

/// A cut-out part: colour times alpha, and alpha.
#[derive(Debug, Clone, PartialEq)]
pub struct Sprite {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green, blue, each times alpha, and alpha; 0..1; row by row.
    pub pixels: Vec<[f32; 4]>,
}

impl Sprite {
    /// Decodes an RGBA PNG that is not multiplied by alpha, such as `gonio matte` writes; `file` is for messages.
    ///
    /// # Errors
    /// The bytes are no PNG, or it has no alpha.
    pub fn decode(file: &str, bytes: &[u8]) -> Result<Self, SceneError> {
        let mend = "name RGBA PNG files that `gonio matte` wrote";
        let decoded = image::load_from_memory_with_format(bytes, image::ImageFormat::Png)
            .map_err(|error| SceneError::new(file, format!("cannot be decoded: {error}"), mend))?;
        if !decoded.color().has_alpha() {
            return Err(SceneError::new(file, "has no alpha channel", mend));
        }
        let rgba = decoded.into_rgba32f();
        let pixels = rgba.pixels().map(|pixel| {
            let [r, g, b, a] = pixel.0;
            [r * a, g * a, b * a, a]
        });
        Ok(Self { width: rgba.width() as usize, height: rgba.height() as usize, pixels: pixels.collect() })
    }

    /// From a colour image, not multiplied, and its alpha, of the same number of pixels.
    pub fn new(colour: &Image, alpha: &[f32]) -> Self {
        let pixels = colour.pixels.iter().zip(alpha).map(|(c, &a)| [c[0] * a, c[1] * a, c[2] * a, a]).collect();
        Self { width: colour.width as usize, height: colour.height as usize, pixels }
    }

    /// The sprite `scale` (above 0) times as large: bilinear, over the mean of what falls into a pixel where it shrinks.
    pub fn scaled(&self, scale: f64) -> Self {
        let size = |size: usize| ((size as f64 * scale).round() as usize).max(1);
        let (width, height) = (size(self.width), size(self.height));
        let taps = (1.0 / scale).ceil().clamp(1.0, 16.0) as usize;
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0_f32; 4];
                for tap in 0..taps * taps {
                    let offset = |k: usize| (k as f64 + 0.5) / taps as f64;
                    let column = (x as f64 + offset(tap % taps)) * self.width as f64 / width as f64 - 0.5;
                    let row = (y as f64 + offset(tap / taps)) * self.height as f64 / height as f64 - 0.5;
                    let value = self.bilinear(column, row);
                    sum = std::array::from_fn(|c| sum[c] + value[c]);
                }
                pixels.push(sum.map(|sum| sum / (taps * taps) as f32));
            }
        }
        Self { width, height, pixels }
    }

    fn bilinear(&self, column: f64, row: f64) -> [f32; 4] {
        let column = column.clamp(0.0, self.width as f64 - 1.0);
        let row = row.clamp(0.0, self.height as f64 - 1.0);
        let (x, y) = (column as usize, row as usize);
        let (right, below) = ((x + 1).min(self.width - 1), (y + 1).min(self.height - 1));
        let (fx, fy) = (column.fract() as f32, row.fract() as f32);
        let at = |x: usize, y: usize| self.pixels[y * self.width + x];
        let (a, b, c, d) = (at(x, y), at(right, y), at(x, below), at(right, below));
        std::array::from_fn(|k| {
            let (top, bottom) = (a[k] + fx * (b[k] - a[k]), c[k] + fx * (d[k] - c[k]));
            top + fy * (bottom - top)
        })
    }
}
