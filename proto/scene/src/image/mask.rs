//! Masks: which pixels of a photo count.

use image::DynamicImage;

use super::{Format, open, raster};
use crate::decoder::shielded;
use crate::error::{Result, SceneError};
use crate::files::Files;

/// Which pixels of an image count.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Mask {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Whether a pixel counts; row by row, the top row first, from the left.
    pub bits: Vec<bool>,
}

/// A pixel counts above this value, of 255.
const THRESHOLD: u8 = 127;

/// Reads the mask file `path`: a gray PNG, TIFF or JPEG of 1, 8 or 16 bits in which a pixel counts where its value is
/// above 127 of 255. Three equal colour channels pass for gray; alpha is passed over.
///
/// # Errors
/// As [`super::read`]; the file has colours or floating-point values; or all of its values are small, so that it seems
/// to have another scale (0 and 1).
pub fn read_mask(files: &dyn Files, path: &str) -> Result<Mask> {
    let (format, bytes) = open(files, path)?;
    let mend = "save the mask as an 8-bit gray PNG, 255 where a pixel counts and 0 elsewhere";
    if matches!(format, Format::OpenExr | Format::Hdr) {
        return Err(SceneError::new(
            path,
            "has floating-point values, and a mask counts by the value 127 of 255",
            mend,
        ));
    }
    let decoded = shielded(path, || raster::decode(path, format, &bytes))?;
    let high = |value: u16| value.to_be_bytes()[0];
    let values = match &decoded {
        DynamicImage::ImageLuma8(image) => gray::<_, 1>(image, |value| value),
        DynamicImage::ImageLumaA8(image) => gray::<_, 2>(image, |value| value),
        DynamicImage::ImageRgb8(image) => gray::<_, 3>(image, |value| value),
        DynamicImage::ImageRgba8(image) => gray::<_, 4>(image, |value| value),
        DynamicImage::ImageLuma16(image) => gray::<_, 1>(image, high),
        DynamicImage::ImageLumaA16(image) => gray::<_, 2>(image, high),
        DynamicImage::ImageRgb16(image) => gray::<_, 3>(image, high),
        DynamicImage::ImageRgba16(image) => gray::<_, 4>(image, high),
        _ => return Err(SceneError::new(path, "has a pixel type that a mask cannot have", mend)),
    };
    let (width, height) = (decoded.width(), decoded.height());
    let values = values.map_err(|first| {
        let columns = (width as usize).max(1);
        SceneError::new(path, "has a colour, so that it is not clear what counts", mend).at(format!(
            "pixel (column {}, row {})",
            first % columns,
            first / columns
        ))
    })?;
    let largest = values.iter().copied().max().unwrap_or(0);
    if (1..=THRESHOLD).contains(&largest) {
        let problem = format!("has the largest value {largest} of 255, so that no pixel counts");
        return Err(SceneError::new(path, problem, mend));
    }
    Ok(Mask { width, height, bits: values.into_iter().map(|value| value > THRESHOLD).collect() })
}

/// One value per pixel, or the number of the first pixel that is not gray.
fn gray<T: Copy + PartialEq, const CHANNELS: usize>(
    samples: &[T],
    value: impl Fn(T) -> u8,
) -> std::result::Result<Vec<u8>, usize> {
    let (pixels, _) = samples.as_chunks::<CHANNELS>();
    let pixels = pixels.iter().enumerate().map(|(number, pixel)| match *pixel.as_slice() {
        [gray] | [gray, _] => Ok(value(gray)),
        [r, g, b] | [r, g, b, _] if r == g && g == b => Ok(value(r)),
        _ => Err(number),
    });
    pixels.collect()
}
