//! Files of the textures that vary a material.

use crate::Result;
use crate::files::FileMap;
use crate::paint::Values;
use crate::surface::Surface;
use gonio_scene::capture::MapRole;
use gonio_scene::image::{Image, encode_exr, encode_png8};

/// How a format stores textures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    /// OpenEXR of 32-bit floats, linear.
    Exact,
    /// PNG of 8 bits: colours in sRGB, other numbers linear.
    Png,
}

/// The path of the texture of a surface's number.
pub fn file(surface: &Surface, role: MapRole, storage: Storage) -> String {
    let end = if storage == Storage::Exact { "exr" } else { "png" };
    let key = role.key().trim_end_matches("_map");
    format!("textures/{}-{key}.{end}", surface.stem)
}

/// Adds the texture of a surface's number to `files`, where `values` are one.
///
/// # Errors
/// An image without pixels.
pub fn add(
    files: &mut FileMap,
    surface: &Surface,
    role: MapRole,
    storage: Storage,
    values: Option<&Values>,
) -> Result<()> {
    let Some(Values::Texture { image, .. }) = values else { return Ok(()) };
    let path = file(surface, role, storage);
    let bytes = match storage {
        Storage::Exact => encode_exr(&path, image)?,
        Storage::Png => png(&path, image, role == MapRole::BaseColor)?,
    };
    files.insert(path, bytes);
    Ok(())
}

/// An image as PNG of 8 bits: values from 0 to 1, `curved` by sRGB's function.
///
/// # Errors
/// An image without pixels.
pub fn png(path: &str, image: &Image, curved: bool) -> Result<Vec<u8>> {
    let encode = |value: f32| if curved { srgb(value) } else { value };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // Clamped to a byte.
    let byte = |value: f32| (encode(value.clamp(0.0, 1.0)) * 255.0).round() as u8;
    let pixels: Vec<[u8; 3]> = image.pixels.iter().map(|pixel| pixel.map(byte)).collect();
    Ok(encode_png8(path, image.width, image.height, &pixels)?)
}

/// IEC 61966-2-1.
fn srgb(value: f32) -> f32 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * libm::powf(value, 1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_is_the_standards() {
        assert_eq!((srgb(0.0), (srgb(1.0) * 255.0).round()), (0.0, 255.0));
        // 18 % gray is 117.6 of 255.
        assert!((srgb(0.18) * 255.0 - 117.6).abs() < 0.1, "{}", srgb(0.18) * 255.0);
    }
}
