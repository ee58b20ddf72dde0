//! Images at other sizes, with their cameras.

use gonio_pose::Intrinsics;
use gonio_scene::image::Image;
use image::imageops::{FilterType, resize};
use image::{ImageBuffer, Rgb, Rgb32FImage};

/// An image and the camera that took it.
#[derive(Debug, Clone)]
pub(crate) struct Picture {
    pub pixels: Rgb32FImage,
    pub camera: Intrinsics,
}

impl Picture {
    pub fn new(image: &Image, camera: &Intrinsics) -> Self {
        let pixels = ImageBuffer::from_fn(image.width, image.height, |column, row| {
            let index = row as usize * image.width as usize + column as usize;
            Rgb(image.pixels.get(index).copied().unwrap_or_default())
        });
        Self { pixels, camera: *camera }
    }

    pub fn width(&self) -> u32 {
        self.pixels.width()
    }

    pub fn height(&self) -> u32 {
        self.pixels.height()
    }

    /// The values of the pixel `index`, counted row by row.
    pub fn at(&self, index: usize) -> [f32; 3] {
        let values = self.pixels.as_raw().get(3 * index..3 * index + 3);
        values.map_or([0.0; 3], |v| [v[0], v[1], v[2]])
    }

    /// The whole picture with sides `factor` times as long, filtered.
    pub fn scaled(&self, factor: f64) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most the largest image's side
        let side = |length: u32| (f64::from(length) * factor).round().max(1.0) as u32;
        let (width, height) = (side(self.width()), side(self.height()));
        let pixels = resize(&self.pixels, width, height, FilterType::Triangle);
        let (sx, sy) = (f64::from(width) / f64::from(self.width()), f64::from(height) / f64::from(self.height()));
        let c = &self.camera;
        // Pixels' edges meet, not their centres.
        let camera =
            Intrinsics { fx: c.fx * sx, fy: c.fy * sy, cx: (c.cx + 0.5) * sx - 0.5, cy: (c.cy + 0.5) * sy - 0.5 };
        Self { pixels, camera }
    }

    /// The part of it from column `x` and row `y` on, `width` and `height` pixels large where it has so many.
    pub fn cropped(&self, x: u32, y: u32, width: u32, height: u32) -> Self {
        let pixels = image::imageops::crop_imm(&self.pixels, x, y, width, height).to_image();
        let camera = Intrinsics { cx: self.camera.cx - f64::from(x), cy: self.camera.cy - f64::from(y), ..self.camera };
        Self { pixels, camera }
    }
}
