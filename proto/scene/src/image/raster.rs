//! PNG, TIFF, JPEG and Radiance HDR, by the `image` crate.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::{Format, Image, limit};
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

const MEND: &str = "save the image again, as OpenEXR, or PNG or TIFF of 8 or 16 bits";

/// Reads an image as colour.
pub(super) fn read(path: &str, format: Format, bytes: &[u8]) -> Result<Image> {
    let decoded = decode(path, format, bytes)?;
    let (width, height) = (decoded.width(), decoded.height());
    let byte = |value: u8| f32::from(value) / 255.0;
    let word = |value: u16| f32::from(value) / 65535.0;
    let pixels = match &decoded {
        DynamicImage::ImageLuma8(image) => gather::<_, 1>(image, byte),
        DynamicImage::ImageLumaA8(image) => gather::<_, 2>(image, byte),
        DynamicImage::ImageRgb8(image) => gather::<_, 3>(image, byte),
        DynamicImage::ImageRgba8(image) => gather::<_, 4>(image, byte),
        DynamicImage::ImageLuma16(image) => gather::<_, 1>(image, word),
        DynamicImage::ImageLumaA16(image) => gather::<_, 2>(image, word),
        DynamicImage::ImageRgb16(image) => gather::<_, 3>(image, word),
        DynamicImage::ImageRgba16(image) => gather::<_, 4>(image, word),
        DynamicImage::ImageRgb32F(image) => gather::<_, 3>(image, |value| value),
        DynamicImage::ImageRgba32F(image) => gather::<_, 4>(image, |value| value),
        _ => return Err(SceneError::new(path, "has a pixel type that is not supported", MEND)),
    };
    Ok(Image { width, height, pixels })
}

/// The width and height in pixels, from the header.
pub(super) fn dimensions(path: &str, format: Format, bytes: &[u8]) -> Result<(u32, u32)> {
    Ok(open(path, format, bytes)?.dimensions())
}

/// The image in its own pixel type.
pub(super) fn decode(path: &str, format: Format, bytes: &[u8]) -> Result<DynamicImage> {
    if format == Format::Jpeg {
        check_jpeg_end(path, bytes)?;
    }
    DynamicImage::from_decoder(open(path, format, bytes)?)
        .map_err(|error| SceneError::new(path, one_line(&error), MEND))
}

fn open<'a>(path: &str, format: Format, bytes: &'a [u8]) -> Result<impl ImageDecoder + use<'a>> {
    let broken = |error: image::ImageError| SceneError::new(path, one_line(&error), MEND);
    let format = match format {
        Format::OpenExr => ImageFormat::OpenExr,
        Format::Hdr => ImageFormat::Hdr,
        Format::Png => ImageFormat::Png,
        Format::Tiff => ImageFormat::Tiff,
        Format::Jpeg => ImageFormat::Jpeg,
    };
    let mut limits = Limits::default();
    limits.max_alloc = Some(limit::MAX_BYTES);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits.clone());
    let mut decoder = reader.into_decoder().map_err(broken)?;
    limit::check(path, decoder.dimensions(), decoder.total_bytes(), bytes.len())?;
    // From here on, a decoder has its own buffers, but none beyond a multiple of what it decodes.
    limits.max_alloc = Some(decoder.total_bytes().saturating_mul(8).saturating_add(1 << 24));
    decoder.set_limits(limits).map_err(broken)?;
    Ok(decoder)
}

/// The JPEG decoder fills what is missing of a truncated file with gray: look for the end-of-image marker behind the last
/// start-of-scan marker. Neither can occur inside of coded data (ITU T.81, B.1.1.5).
fn check_jpeg_end(path: &str, bytes: &[u8]) -> Result<()> {
    let last = |marker: [u8; 2]| bytes.windows(2).rposition(|window| window == marker);
    match (last([0xff, 0xda]), last([0xff, 0xd9])) {
        (Some(scan), Some(end)) if scan < end => Ok(()),
        _ => Err(SceneError::new(path, "is truncated: the end-of-image marker is missing", "save the image again")),
    }
}

fn gather<T: Copy, const CHANNELS: usize>(samples: &[T], value: impl Fn(T) -> f32) -> Vec<[f32; 3]> {
    let (pixels, _) = samples.as_chunks::<CHANNELS>();
    let colour = |pixel: &[T; CHANNELS]| match *pixel.as_slice() {
        [r, g, b] | [r, g, b, _] => [r, g, b].map(&value),
        [gray] | [gray, _] => [value(gray); 3],
        _ => [f32::NAN; 3],
    };
    pixels.iter().map(colour).collect()
}
