//! Writes photos and masks.

use exr::prelude::{Compression, Encoding, Image, LineOrder, SpecificChannels, Vec2, WritableImage, f16};
use gonio_scene::Capture;
use image::{ImageBuffer, Luma, Rgb};
use std::path::Path;

/// What a photo's file is.
#[derive(Clone, Copy)]
pub enum Format {
    /// OpenEXR of 16-bit floats.
    Half,
    /// PNG of 16-bit integers above a black level.
    Png,
}

/// What a 16-bit file holds without light: more than six standard deviations of the source's read noise of 0.003.
const BLACK_LEVEL: f64 = 0.02;

impl Format {
    /// The format of a name.
    pub fn named(name: &str) -> Self {
        match name {
            "half" => Self::Half,
            "png" => Self::Png,
            other => panic!("--format {other}: write half or png"),
        }
    }

    /// Gives the capture the keys that a file of this format needs.
    pub fn adapt(self, capture: &mut Capture) {
        if let Self::Png = self {
            capture.sensor.black_level = BLACK_LEVEL;
            capture.sensor.saturation = Some(1.0);
        }
    }

    /// Writes a photo and returns its path in the folder.
    pub fn write(self, folder: &Path, stem: &str, (width, height): (u32, u32), values: &[[f32; 3]]) -> String {
        match self {
            Self::Half => {
                let path = format!("{stem}.exr");
                let pixel = |at: Vec2<usize>| {
                    let [r, g, b] = values[at.y() * width as usize + at.x()].map(f16::from_f32);
                    (r, g, b)
                };
                let encoding = Encoding {
                    compression: Compression::ZIP16,
                    line_order: LineOrder::Increasing,
                    ..Encoding::FAST_LOSSLESS
                };
                let channels = SpecificChannels::rgb(pixel);
                let image = Image::from_encoded_channels((width as usize, height as usize), encoding, channels);
                image.write().to_file(folder.join(&path)).unwrap();
                path
            }
            Self::Png => {
                let path = format!("{stem}.png");
                let word = |v: f32| (v.clamp(0.0, 1.0) * 65535.0).round() as u16;
                let pixel = |x: u32, y: u32| Rgb(values[(y * width + x) as usize].map(word));
                ImageBuffer::from_fn(width, height, pixel).save(folder.join(&path)).unwrap();
                path
            }
        }
    }
}

/// Writes a mask and returns its path in the folder.
pub fn mask(folder: &Path, stem: &str, (width, height): (u32, u32), counts: impl Fn(u32, u32) -> bool) -> String {
    let path = format!("{stem}.mask.png");
    let pixel = |x: u32, y: u32| Luma([if counts(x, y) { 255_u8 } else { 0 }]);
    ImageBuffer::from_fn(width, height, pixel).save(folder.join(&path)).unwrap();
    path
}
