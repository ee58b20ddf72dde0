//! Images whose pixels are samples in a row: PNG, JPEG and Radiance HDR by the `image` crate, TIFF by [`super::tiff`].

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::{Format, Image, hdr, limit, tiff};
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

const MEND: &str = "save the image again, as OpenEXR, or PNG or TIFF of 8 or 16 bits";

/// Samples as the file has them.
#[derive(Debug)]
pub(super) enum Samples {
    U8(Vec<u8>),
    U16(Vec<u16>),
    U32(Vec<u32>),
    F32(Vec<f32>),
}

/// A decoded image: gray, gray with alpha, colour, or colour with alpha, by its number of channels.
#[derive(Debug)]
pub(super) struct Raster {
    pub width: u32,
    pub height: u32,
    pub channels: usize,
    /// Whether a channel's samples stand together, rather than a pixel's.
    pub planar: bool,
    pub samples: Samples,
}

impl Raster {
    /// The same, when it has all of its samples.
    pub(super) fn complete(self, path: &str) -> Result<Self> {
        let samples = match &self.samples {
            Samples::U8(values) => values.len(),
            Samples::U16(values) => values.len(),
            Samples::U32(values) => values.len(),
            Samples::F32(values) => values.len(),
        };
        if samples >= self.pixels() * self.channels {
            return Ok(self);
        }
        let problem = format!("has {samples} samples for {} x {} pixels", self.width, self.height);
        Err(SceneError::new(path, problem, MEND))
    }

    pub(super) fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// A sample: integers as a fraction of their largest.
    #[allow(clippy::cast_possible_truncation)]
    pub(super) fn value(&self, pixel: usize, channel: usize) -> f32 {
        let index = if self.planar { channel * self.pixels() + pixel } else { pixel * self.channels + channel };
        // All samples were counted before. Not a number is refused, where a zero would pass unseen.
        match &self.samples {
            Samples::U8(values) => values.get(index).map_or(f32::NAN, |value| f32::from(*value) / 255.0),
            Samples::U16(values) => values.get(index).map_or(f32::NAN, |value| f32::from(*value) / 65535.0),
            Samples::U32(values) => {
                values.get(index).map_or(f32::NAN, |value| (f64::from(*value) / f64::from(u32::MAX)) as f32)
            }
            Samples::F32(values) => values.get(index).copied().unwrap_or(f32::NAN),
        }
    }

    /// The colour, without alpha.
    pub(super) fn image(&self) -> Image {
        let colour = |pixel: usize| match self.channels {
            1 | 2 => [self.value(pixel, 0); 3],
            _ => [0, 1, 2].map(|channel| self.value(pixel, channel)),
        };
        Image { width: self.width, height: self.height, pixels: (0..self.pixels()).map(colour).collect() }
    }

    /// The alpha of every pixel; `None` where the file has none.
    pub(super) fn alpha(&self) -> Option<impl Iterator<Item = f32> + '_> {
        let channel = matches!(self.channels, 2 | 4).then(|| self.channels - 1)?;
        Some((0..self.pixels()).map(move |pixel| self.value(pixel, channel)))
    }
}

/// Reads the samples of an image.
pub(super) fn read(path: &str, format: Format, bytes: &[u8]) -> Result<Raster> {
    if format == Format::Tiff {
        return tiff::read(path, bytes);
    }
    if format == Format::Jpeg {
        check_jpeg_end(path, bytes)?;
    }
    let decoded = DynamicImage::from_decoder(open(path, format, bytes)?)
        .map_err(|error| SceneError::new(path, one_line(&error), MEND))?;
    let (width, height) = (decoded.width(), decoded.height());
    let (channels, samples) = match decoded {
        DynamicImage::ImageLuma8(image) => (1, Samples::U8(image.into_raw())),
        DynamicImage::ImageLumaA8(image) => (2, Samples::U8(image.into_raw())),
        DynamicImage::ImageRgb8(image) => (3, Samples::U8(image.into_raw())),
        DynamicImage::ImageRgba8(image) => (4, Samples::U8(image.into_raw())),
        DynamicImage::ImageLuma16(image) => (1, Samples::U16(image.into_raw())),
        DynamicImage::ImageLumaA16(image) => (2, Samples::U16(image.into_raw())),
        DynamicImage::ImageRgb16(image) => (3, Samples::U16(image.into_raw())),
        DynamicImage::ImageRgba16(image) => (4, Samples::U16(image.into_raw())),
        DynamicImage::ImageRgb32F(image) => (3, Samples::F32(image.into_raw())),
        DynamicImage::ImageRgba32F(image) => (4, Samples::F32(image.into_raw())),
        _ => return Err(SceneError::new(path, "has a pixel type that is not supported", MEND)),
    };
    Raster { width, height, channels, planar: false, samples }.complete(path)
}

/// The width and height in pixels, from the header.
pub(super) fn dimensions(path: &str, format: Format, bytes: &[u8]) -> Result<(u32, u32)> {
    match format {
        Format::Tiff => tiff::dimensions(path, bytes),
        Format::Hdr => Ok(open(path, format, &hdr::as_rgb(bytes))?.dimensions()),
        _ => Ok(open(path, format, bytes)?.dimensions()),
    }
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
    check_orientation(path, u16::from(decoder.orientation().map_err(broken)?.to_exif()))?;
    Ok(decoder)
}

/// Refuses a file that says to be shown turned or mirrored: who calibrated its camera may have followed that or not, so
/// that nobody knows which pixel a camera means.
pub(super) fn check_orientation(path: &str, orientation: u16) -> Result<()> {
    if orientation <= 1 {
        return Ok(());
    }
    let problem = format!("says by its orientation {orientation} that it is to be shown turned or mirrored");
    let mend = "turn the pixels and drop the mark (exiftran -a, mogrify -auto-orient), and give the camera of those";
    Err(SceneError::new(path, problem, mend).at("Orientation"))
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
