//! TIFF and BigTIFF, by the `tiff` crate: it says of which type the samples are, which the `image` crate does not.

use std::io::Cursor;

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::limit;
use super::raster::{Raster, Samples, check_orientation};
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

const MEND: &str = "save it as TIFF of 8, 10, 12, 14, 16 or 32 unsigned bits or 32-bit floats, gray or RGB";
/// Bits of samples that share bytes with their neighbours, as sensors have them.
const PACKED: [u8; 3] = [10, 12, 14];

/// The samples of the file's first image.
pub(super) fn read(path: &str, bytes: &[u8]) -> Result<Raster> {
    let (mut decoder, [width, height], channels, bits) = open(path, bytes)?;
    if PACKED.contains(&bits) {
        let layout = decoder.image_buffer_layout().map_err(|error| broken(path, &error))?;
        let mut packed = vec![0; layout.len.saturating_mul(layout.planes.max(1))];
        decoder.read_image_bytes(&mut packed).map_err(|error| broken(path, &error))?;
        let planar = layout.planes > 1;
        let swapped = bytes.starts_with(b"MM") != cfg!(target_endian = "big");
        let columns = width as usize * if planar { 1 } else { channels };
        let samples = Samples::U16(unpacked16(&mut packed, columns, bits, swapped));
        return Raster { width, height, channels, planar, samples }.complete(path);
    }
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
    if !([8, 16, 32, 64].contains(&bits) || PACKED.contains(&bits) || (channels == 1 && [1, 2, 4].contains(&bits))) {
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

/// Samples of 10 to 14 bits, each as its share of 65535. Rows begin at a byte, and bits run from a byte's high end, whatever
/// the file's byte order (TIFF 6.0, FillOrder); `swapped` says that the decoder took the bytes for numbers of two bytes and
/// turned each pair.
fn unpacked16(packed: &mut [u8], columns: usize, bits: u8, swapped: bool) -> Vec<u16> {
    let row = (columns * usize::from(bits)).div_ceil(8).max(1);
    let largest = (1_u32 << bits) - 1;
    let mut samples = Vec::with_capacity(packed.len() / row * columns);
    for row in packed.chunks_mut(row) {
        if swapped {
            row.as_chunks_mut::<2>().0.iter_mut().for_each(|pair| pair.swap(0, 1));
        }
        for column in 0..columns {
            let start = column * usize::from(bits);
            let byte = |k: usize| u32::from(row.get(start / 8 + k).copied().unwrap_or(0));
            let window = byte(0) << 16 | byte(1) << 8 | byte(2);
            let value = window >> (24 - u32::from(bits) - (start % 8) as u32) & largest;
            samples.push(u16::try_from((value * 65535 + largest / 2) / largest).unwrap_or(u16::MAX));
        }
    }
    samples
}

fn broken(path: &str, error: &tiff::TiffError) -> SceneError {
    SceneError::new(path, one_line(error), MEND)
}

#[cfg(test)]
mod tests {
    use super::{read, unpacked};
    use crate::image::raster::Samples;

    #[test]
    fn packed_rows_begin_at_a_byte() {
        assert_eq!(unpacked(&[0b1010_0000, 0b0100_0000], 3, 1), [255, 0, 255, 0, 255, 0]);
        assert_eq!(unpacked(&[0xf0, 0x50], 3, 4), [255, 0, 85]);
    }

    /// An uncompressed TIFF of one strip, by TIFF 6.0's tables: two rows of samples.
    fn file(big: bool, bits: u16, channels: u16, width: u16, strip: &[u8]) -> Vec<u8> {
        let short = |value: u16| if big { value.to_be_bytes() } else { value.to_le_bytes() };
        let long = |value: u32| if big { value.to_be_bytes() } else { value.to_le_bytes() };
        let mut bytes = if big { b"MM".to_vec() } else { b"II".to_vec() };
        bytes.extend(short(42));
        bytes.extend(long(8));
        let entries = [
            (256, width),
            (257, 2),
            (258, bits),
            (259, 1),
            (262, if channels == 1 { 1 } else { 2 }),
            (273, 8 + 2 + 9 * 12 + 4),
            (277, channels),
            (278, 2),
            (279, strip.len() as u16),
        ];
        bytes.extend(short(entries.len() as u16));
        for (tag, value) in entries {
            bytes.extend([short(tag), short(3)].concat());
            bytes.extend(long(1));
            bytes.extend([short(value), [0; 2]].concat());
        }
        bytes.extend(long(0));
        bytes.extend(strip);
        bytes
    }

    #[test]
    fn samples_of_twelve_bits_in_either_byte_order() {
        // Three samples of 12 bits take 36 bits, so that a row ends in half a byte.
        let rows = [0x00, 0x0f, 0xff, 0x80, 0x00, 0x12, 0x3f, 0xf0, 0x00, 0x10];
        let expected = [0x000_u32, 0xfff, 0x800, 0x123, 0xff0, 0x001].map(|value| (value * 65535 + 2047) / 4095);
        for (big, channels, width) in [(false, 1, 3), (true, 1, 3), (false, 3, 1), (true, 3, 1)] {
            let raster = read("a.tif", &file(big, 12, channels, width, &rows)).unwrap();
            let Samples::U16(samples) = raster.samples else { panic!("not of 16 bits") };
            assert_eq!(samples.iter().map(|v| u32::from(*v)).collect::<Vec<_>>(), expected, "{big} {channels}");
        }
        // 10 and 14 bits: one row of four samples each.
        let ten = file(false, 10, 1, 4, &[0xff, 0xc0, 0x10, 0x08, 0x00, 0, 0, 0, 0, 0]);
        let Samples::U16(samples) = read("a.tif", &ten).unwrap().samples else { panic!("not of 16 bits") };
        assert_eq!(samples[..4], [65535, 64, 128, 0]);
        let refused = read("a.tif", &file(false, 11, 1, 3, &[0; 10])).unwrap_err().to_string();
        assert!(refused.contains("11 bits") && refused.contains("12"), "{refused}");
    }
}
