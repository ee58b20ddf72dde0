//! TIFF and BigTIFF, by the `tiff` crate: it says of which type the samples are, which the `image` crate does not.

use std::io::Cursor;

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::limit;
use super::raster::{Raster, Samples, check_orientation};
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

const MEND: &str = "save it as TIFF of 8, 16 or 32 unsigned bits or 32-bit floats, gray or RGB";

/// The samples of the file's first image.
pub(super) fn read(path: &str, bytes: &[u8]) -> Result<Raster> {
    let (mut decoder, [width, height], channels, bits) = open(path, bytes)?;
    let mut result = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut result).map_err(|error| broken(path, &error))?;
    let planar = layout.planes > 1;
    let narrow = |values: Vec<f64>| {
        #[allow(clippy::cast_possible_truncation)]
        Samples::F32(values.into_iter().map(|value| value as f32).collect())
    };
    let samples = match result {
        DecodingResult::U8(values) if bits < 8 => Samples::U8(unpacked(&values, width as usize, bits)),
        DecodingResult::U8(values) => Samples::U8(values),
        DecodingResult::U16(values) => Samples::U16(values),
        DecodingResult::U32(values) => Samples::U32(values),
        DecodingResult::F16(values) => Samples::F32(values.into_iter().map(exr::prelude::f16::to_f32).collect()),
        DecodingResult::F32(values) => Samples::F32(values),
        DecodingResult::F64(values) => narrow(values),
        DecodingResult::U64(_) => return Err(SceneError::new(path, "has samples of 64 bits", MEND)),
        _ => return Err(SceneError::new(path, "has samples with a sign", MEND)),
    };
    let raster = Raster { width, height, channels, planar, samples };
    raster.complete(path)
}

/// The width and height in pixels, from the header.
pub(super) fn dimensions(path: &str, bytes: &[u8]) -> Result<(u32, u32)> {
    let (_, [width, height], ..) = open(path, bytes)?;
    Ok((width, height))
}

type Opened<'a> = (Decoder<Cursor<&'a [u8]>>, [u32; 2], usize, u8);

/// A decoder of what fits into the limits, the size, the channels that count and the bits of each.
fn open<'a>(path: &str, bytes: &'a [u8]) -> Result<Opened<'a>> {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = usize::try_from(limit::MAX_BYTES).unwrap_or(usize::MAX);
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(|error| broken(path, &error))?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(|error| broken(path, &error))?;
    let colour = decoder.colortype().map_err(|error| broken(path, &error))?;
    let (channels, bits) = match colour {
        ColorType::Gray(bits) => (1, bits),
        ColorType::RGB(bits) => (3, bits),
        ColorType::RGBA(bits) => (4, bits),
        ColorType::GrayA(bits) | ColorType::Multiband { bit_depth: bits, num_samples: 2 } => (2, bits),
        other => return Err(SceneError::new(path, format!("has pixels of the kind {other:?}"), MEND)),
    };
    if !([8, 16, 32, 64].contains(&bits) || (channels == 1 && [1, 2, 4].contains(&bits))) {
        return Err(SceneError::new(path, format!("has samples of {bits} bits"), MEND));
    }
    let pixels = u64::from(width).saturating_mul(u64::from(height));
    let total = pixels.saturating_mul(channels as u64).saturating_mul(u64::from(bits)).div_ceil(8);
    limit::check(path, (width, height), total, bytes.len())?;
    if let Ok(Some(orientation)) = decoder.find_tag_unsigned::<u16>(Tag::Orientation) {
        check_orientation(path, orientation)?;
    }
    Ok((decoder, [width, height], channels, bits))
}

/// Samples of less than a byte, each as its share of 255. Rows begin at a byte.
fn unpacked(packed: &[u8], width: usize, bits: u8) -> Vec<u8> {
    let row = (width * usize::from(bits)).div_ceil(8).max(1);
    let largest = (1_u16 << bits) - 1;
    let sample = |row: &[u8], column: usize| {
        let start = column * usize::from(bits);
        let byte = u16::from(row.get(start / 8).copied().unwrap_or(0));
        let value = byte >> (8 - usize::from(bits) - start % 8) & largest;
        u8::try_from(value * 255 / largest).unwrap_or(u8::MAX)
    };
    packed.chunks(row).flat_map(|row| (0..width).map(move |column| sample(row, column))).collect()
}

fn broken(path: &str, error: &tiff::TiffError) -> SceneError {
    SceneError::new(path, one_line(error), MEND)
}

#[cfg(test)]
mod tests {
    use super::unpacked;

    #[test]
    fn packed_rows_begin_at_a_byte() {
        assert_eq!(unpacked(&[0b1010_0000, 0b0100_0000], 3, 1), [255, 0, 255, 0, 255, 0]);
        assert_eq!(unpacked(&[0xf0, 0x50], 3, 4), [255, 0, 85]);
    }
}
