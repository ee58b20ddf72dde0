//! A matte as a file.

use super::Matte;
use gonio_scene::SceneError;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

/// Bits of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Depth {
    /// 256 levels.
    #[default]
    Eight,
    /// 65536 levels.
    Sixteen,
}

/// The bytes of an RGBA PNG, not multiplied by alpha; `file` is named in errors only.
///
/// # Errors
/// The matte has no pixels.
pub fn encode(file: &str, matte: &Matte, depth: Depth) -> Result<Vec<u8>, SceneError> {
    let (width, height) = (matte.colour.width, matte.colour.height);
    let values = matte
        .colour
        .pixels
        .iter()
        .zip(&matte.alpha)
        .flat_map(|(colour, &alpha)| [colour[0], colour[1], colour[2], alpha])
        .map(|value| value.clamp(0.0, 1.0));
    let (bytes, kind): (Vec<u8>, _) = match depth {
        Depth::Eight => (values.map(|value| (value * 255.0).round() as u8).collect(), ExtendedColorType::Rgba8),
        Depth::Sixteen => (
            // The encoder takes the machine's byte order.
            values.flat_map(|value| ((value * 65535.0).round() as u16).to_ne_bytes()).collect(),
            ExtendedColorType::Rgba16,
        ),
    };
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(&bytes, width, height, kind)
        .map_err(|error| SceneError::new(file, error.to_string(), "give photos with at least one pixel"))?;
    Ok(png)
}
