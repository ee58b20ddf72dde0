//! Textures: images whose values are factors on a material's numbers, made linear.

use super::raster::{self, Raster, Samples};
use super::{Claims, Format, Image, check_finite, claims_of, exr, format_of, hdr, open};
use crate::decoder::shielded;
use crate::error::{Result, SceneError};
use crate::files::Files;

/// How a texture's values become linear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Curve {
    /// A colour as its file says: integers are sRGB unless a PNG's `gAMA` says that they are linear; floats are linear.
    Colour,
    /// Integers are sRGB, whatever the file says: colours of glTF (2.0, section 3.9.2).
    Srgb,
    /// As they are: roughness and metallic.
    Linear,
}

/// PNG's `gAMA` of values for a display: 1 / 2.2.
const DISPLAY: f64 = 0.454_55;
/// Exponents that differ by less are written with fewer digits.
const SAME: f64 = 1e-3;

/// Reads the texture `path`: any image that [`super::read`] reads. Gray becomes three equal channels, alpha is passed over.
///
/// # Errors
/// As [`super::read`]; a value below 0; a PNG whose `gAMA` is neither that of sRGB nor 1, where that counts.
pub fn read_texture(files: &dyn Files, path: &str, curve: Curve) -> Result<Image> {
    let (format, bytes) = open(files, path)?;
    texture(path, format, &bytes, curve)
}

/// As [`read_texture`], from the bytes of a PNG or JPEG; `place` is for messages.
///
/// # Errors
/// As [`read_texture`].
pub fn decode_texture(place: &str, bytes: &[u8], curve: Curve) -> Result<Image> {
    let format = format_of(bytes).ok_or_else(|| {
        SceneError::new(place, "is no image of a known format", "embed a PNG or a JPEG, or keep the image in a file")
    })?;
    texture(place, format, bytes, curve)
}

fn texture(path: &str, format: Format, bytes: &[u8], curve: Curve) -> Result<Image> {
    let (mut image, integers) = shielded(path, || match format {
        Format::OpenExr => Ok((exr::read(path, bytes)?.0, false)),
        Format::Hdr => Ok((hdr::read(path, bytes)?, false)),
        _ => {
            let raster = raster::read(path, format, bytes)?;
            Ok((raster.image(), is_integer(&raster)))
        }
    })?;
    check_finite(path, &image)?;
    if let Some(pixel) = image.pixels.iter().position(|pixel| pixel.iter().any(|value| *value < 0.0)) {
        let width = (image.width as usize).max(1);
        let place = format!("pixel (column {}, row {})", pixel % width, pixel / width);
        return Err(SceneError::new(path, "has a value below 0, which no reflectance is", "clamp it to 0").at(place));
    }
    if integers && is_curved(path, curve, &claims_of(path, format, bytes)?)? {
        image.pixels.iter_mut().flatten().for_each(|value| *value = linear(*value));
    }
    Ok(image)
}

fn is_integer(raster: &Raster) -> bool {
    !matches!(raster.samples, Samples::F32(_))
}

/// Whether integers have sRGB's curve.
fn is_curved(path: &str, curve: Curve, claims: &Claims) -> Result<bool> {
    match (curve, claims.gamma) {
        (Curve::Linear, _) => Ok(false),
        (Curve::Srgb, _) | (Curve::Colour, None) => Ok(true),
        (Curve::Colour, Some(gamma)) if claims.srgb || (gamma - DISPLAY).abs() < SAME => Ok(true),
        (Curve::Colour, Some(gamma)) if (gamma - 1.0).abs() < SAME => Ok(false),
        (Curve::Colour, Some(gamma)) => Err(SceneError::new(
            path,
            format!("says by its gAMA that its values are light to the power {gamma}"),
            "save it as sRGB, or linear with gAMA 1, or as OpenEXR",
        )
        .at("gAMA")),
    }
}

/// sRGB's value 0..=1 as linear light: IEC 61966-2-1.
#[must_use]
#[allow(clippy::cast_possible_truncation)]
pub fn linear(value: f32) -> f32 {
    let value = f64::from(value);
    let light = if value <= 0.040_45 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) };
    light as f32
}
