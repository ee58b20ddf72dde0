//! Depth images: 16-bit gray PNG, 0 where nothing was measured.

use gonio_scene::files::Files;
use gonio_scene::{Result, SceneError};
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageFormat, codecs::png::PngEncoder};

/// Depth along the camera's axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Depth {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// z of what a pixel sees, in metres, row by row from the top; 0 where it is not known.
    pub metres: Vec<f32>,
}

impl Depth {
    /// Reads the depth image `path`, one step of which is `step` metres.
    ///
    /// # Errors
    /// The file cannot be read, or is no 16-bit gray PNG.
    pub fn read(files: &dyn Files, path: &str, step: f64) -> Result<Self> {
        let bytes = files.read(path)?;
        let mend = "save the depth as PNG, 16 bits, gray";
        match image::load_from_memory_with_format(&bytes, ImageFormat::Png) {
            Ok(DynamicImage::ImageLuma16(image)) => Ok(Self {
                width: image.width(),
                height: image.height(),
                #[allow(clippy::cast_possible_truncation)] // 16 bits of depth fit 24 of a float
                metres: image.as_raw().iter().map(|&value| (f64::from(value) * step) as f32).collect(),
            }),
            Ok(_) => Err(SceneError::new(path, "is no 16-bit gray image", mend)),
            Err(error) => Err(SceneError::new(path, format!("is no PNG: {error}"), mend)),
        }
    }
}

/// A depth image's file, one step of which is `step` metres; what lies beyond the last step is not known.
///
/// # Errors
/// Another number of values than the size says.
pub fn encode_depth(file: &str, depth: &Depth, step: f64) -> Result<Vec<u8>> {
    if u64::from(depth.width) * u64::from(depth.height) != depth.metres.len() as u64 {
        return Err(SceneError::new(file, "would have another number of values than pixels", "give one per pixel"));
    }
    let word = |&metres: &f32| {
        let steps = (f64::from(metres) / step).round();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // in range
        if (1.0..=f64::from(u16::MAX)).contains(&steps) { steps as u16 } else { 0 }
    };
    let native: Vec<u8> = depth.metres.iter().flat_map(|metres| word(metres).to_ne_bytes()).collect();
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(&native, depth.width, depth.height, ExtendedColorType::L16)
        .map_err(|error| SceneError::new(file, error.to_string(), "write an image with at least one pixel"))?;
    Ok(bytes)
}
