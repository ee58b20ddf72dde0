//! A small image in every image format.

use std::io::Cursor;

use exr::prelude::*;
use image::{ExtendedColorType, ImageEncoder, codecs};

pub const WIDTH: u32 = 7;
pub const HEIGHT: u32 = 5;

/// Values from 1e-4 to 30, all different.
pub fn values() -> Vec<[f32; 3]> {
    (0..WIDTH * HEIGHT).map(|i| [i as f32 * 0.31 + 1e-4, (i * i) as f32 * 0.02 + 0.1, 30.0 - i as f32 * 0.7]).collect()
}

pub fn bytes8(channels: usize) -> Vec<u8> {
    (0..(WIDTH * HEIGHT) as usize * channels).map(|i| (i * 37 % 256) as u8).collect()
}

pub fn words16(channels: usize) -> Vec<u16> {
    (0..(WIDTH * HEIGHT) as usize * channels).map(|i| (i * 9973 % 65536) as u16).collect()
}

/// 16-bit samples as the `image` encoders take them: in the machine's byte order.
pub fn native(words: &[u16]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_ne_bytes()).collect()
}

pub fn png(samples: &[u8], color: ExtendedColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    codecs::png::PngEncoder::new(&mut bytes).write_image(samples, WIDTH, HEIGHT, color).unwrap();
    bytes
}

/// One bit of gray per pixel, one byte per row, which the encoder of the `image` crate does not write.
pub fn png_of_one_bit(rows: &[u8; HEIGHT as usize]) -> Vec<u8> {
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    let header = [&WIDTH.to_be_bytes()[..], &HEIGHT.to_be_bytes(), &[1, 0, 0, 0, 0]].concat();
    let data: Vec<u8> = rows.iter().flat_map(|&row| [0, row]).collect();
    // Deflate, stored: a zlib header, one final block of plain bytes, their checksum.
    let length = data.len() as u16;
    let (mut low, mut high) = (1u32, 0u32);
    for &byte in &data {
        low = (low + u32::from(byte)) % 65521;
        high = (high + low) % 65521;
    }
    let zlib =
        [&[0x78, 1, 1][..], &length.to_le_bytes(), &(!length).to_le_bytes(), &data, &(high << 16 | low).to_be_bytes()];
    for (kind, content) in [(b"IHDR", header), (b"IDAT", zlib.concat()), (b"IEND", Vec::new())] {
        let chunk = [&kind[..], &content].concat();
        bytes.extend((content.len() as u32).to_be_bytes());
        bytes.extend(&chunk);
        bytes.extend(crc32(&chunk).to_be_bytes());
    }
    bytes
}

pub fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), step))
}

pub fn tiff(samples: &[u8], color: ExtendedColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    codecs::tiff::TiffEncoder::new(Cursor::new(&mut bytes)).write_image(samples, WIDTH, HEIGHT, color).unwrap();
    bytes
}

pub fn jpeg(samples: &[u8], color: ExtendedColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 95).write_image(samples, WIDTH, HEIGHT, color).unwrap();
    bytes
}

pub fn hdr(values: &[[f32; 3]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let pixels: Vec<_> = values.iter().map(|&pixel| image::Rgb(pixel)).collect();
    codecs::hdr::HdrEncoder::new(&mut bytes).encode(&pixels, WIDTH as usize, HEIGHT as usize).unwrap();
    bytes
}

/// A layer of an OpenEXR file: where its data window starts, and its channels.
pub fn layer(
    name: &str,
    position: (i32, i32),
    size: (usize, usize),
    channels: Vec<(&str, FlatSamples)>,
    compression: Compression,
) -> Layer<AnyChannels<FlatSamples>> {
    let attributes = LayerAttributes { layer_position: position.into(), ..LayerAttributes::named(name) };
    let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let channels = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    Layer::new(size, attributes, encoding, AnyChannels::sort(channels))
}

/// An OpenEXR file; the display window is that of [`WIDTH`] x [`HEIGHT`] at `origin`.
pub fn exr(origin: (i32, i32), layers: Vec<Layer<AnyChannels<FlatSamples>>>) -> Vec<u8> {
    let window = IntegerBounds::new(origin, (WIDTH as usize, HEIGHT as usize));
    let image = Image::from_layers(ImageAttributes::new(window), layers);
    let mut bytes = Vec::new();
    image.write().to_buffered(Cursor::new(&mut bytes)).unwrap();
    bytes
}

/// A channel of [`values`] as 32-bit floats.
pub fn channel(index: usize) -> FlatSamples {
    FlatSamples::F32(values().iter().map(|pixel| pixel[index]).collect())
}

/// An OpenEXR file of [`values`] with one layer.
pub fn plain_exr(compression: Compression) -> Vec<u8> {
    let channels = vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
    exr((0, 0), vec![layer("main", (0, 0), (WIDTH as usize, HEIGHT as usize), channels, compression)])
}
