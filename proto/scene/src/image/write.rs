//! Writing images: OpenEXR for values, PNG for eyes.

use std::io::Cursor;
use std::path::Path;

use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image as ExrImage};
use exr::meta::attribute::LineOrder;
use exr::prelude::{Compression, WritableImage};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

use super::Image;
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

/// Lossless, and read by everything that reads OpenEXR. The line order keeps the bytes the same for any thread count.
const ENCODING: Encoding =
    Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };

/// Writes `image` to `path` as OpenEXR with the 32-bit float channels R, G, B; [`super::read`] gives the same bits.
///
/// # Errors
/// The image has no pixels or another number than its size says, or the file cannot be written.
pub fn write_exr(path: &Path, image: &Image) -> Result<()> {
    write(path, &encode_exr(&name(path), image)?)
}

/// The bytes of [`write_exr`]; `file` is named in errors only.
///
/// # Errors
/// The image has no pixels, or another number than its size says.
pub fn encode_exr(file: &str, image: &Image) -> Result<Vec<u8>> {
    let channel = |index: usize| image.pixels.iter().map(|pixel| pixel[index]).collect();
    encode_exr_channels(file, image.width, image.height, &[("R", channel(0)), ("G", channel(1)), ("B", channel(2))])
}

/// Writes OpenEXR with any 32-bit float channels: a name and `width * height` values each, top row first.
///
/// # Errors
/// There is no channel, a name is empty, not ASCII or there twice, a channel has another number of values than the size
/// says, or the file cannot be written.
pub fn write_exr_channels(path: &Path, width: u32, height: u32, channels: &[(&str, Vec<f32>)]) -> Result<()> {
    write(path, &encode_exr_channels(&name(path), width, height, channels)?)
}

/// The bytes of [`write_exr_channels`]; `file` is named in errors only.
///
/// # Errors
/// As [`write_exr_channels`], except for the file.
pub fn encode_exr_channels(file: &str, width: u32, height: u32, channels: &[(&str, Vec<f32>)]) -> Result<Vec<u8>> {
    if width == 0 || height == 0 || channels.is_empty() {
        let problem = format!("would have {width} x {height} pixels in {} channels", channels.len());
        return Err(SceneError::new(file, problem, "write at least one pixel and one channel"));
    }
    for (number, (name, values)) in channels.iter().enumerate() {
        check_count(file, width, height, values.len()).map_err(|error| error.at(*name))?;
        let twice = channels.iter().skip(number + 1).any(|(other, _)| other == name);
        if twice || name.is_empty() || name.len() > 255 || !name.bytes().all(|byte| byte.is_ascii_graphic()) {
            let mend = "name each channel differently, by up to 255 ASCII letters, digits and points";
            return Err(SceneError::new(file, format!("would have a channel named {name:?}"), mend));
        }
    }
    let channel = |(name, values): &(&str, Vec<f32>)| AnyChannel::new(*name, FlatSamples::F32(values.clone()));
    let image = ExrImage::from_encoded_channels(
        (width as usize, height as usize),
        ENCODING,
        AnyChannels::sort(channels.iter().map(channel).collect()),
    );
    let mut bytes = Vec::new();
    let written = image.write().to_buffered(Cursor::new(&mut bytes));
    written.map_err(|error| SceneError::new(file, one_line(&error), "write a smaller image"))?;
    Ok(bytes)
}

/// Writes an 8-bit colour PNG: `width * height` pixels, the top row first.
///
/// # Errors
/// There are no pixels or another number than the size says, or the file cannot be written.
pub fn write_png8(path: &Path, width: u32, height: u32, pixels: &[[u8; 3]]) -> Result<()> {
    write(path, &encode_png8(&name(path), width, height, pixels)?)
}

/// The bytes of [`write_png8`]; `file` is named in errors only.
///
/// # Errors
/// There are no pixels, or another number than the size says.
pub fn encode_png8(file: &str, width: u32, height: u32, pixels: &[[u8; 3]]) -> Result<Vec<u8>> {
    check_count(file, width, height, pixels.len())?;
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(pixels.as_flattened(), width, height, ExtendedColorType::Rgb8)
        .map_err(|error| SceneError::new(file, one_line(&error), "write an image with at least one pixel"))?;
    Ok(bytes)
}

fn check_count(file: &str, width: u32, height: u32, count: usize) -> Result<()> {
    if u64::from(width) * u64::from(height) == count as u64 {
        return Ok(());
    }
    let problem = format!("would have {count} values for {width} x {height} pixels");
    Err(SceneError::new(file, problem, "write one value per pixel"))
}

fn name(path: &Path) -> String {
    path.display().to_string()
}

/// Writes beside the file and renames, so that an interrupted run leaves no half of one.
fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut partial = path.as_os_str().to_owned();
    partial.push(".part");
    std::fs::write(&partial, bytes).and_then(|()| std::fs::rename(&partial, path)).map_err(|error| {
        SceneError::new(
            name(path),
            format!("cannot be written: {error}"),
            "create its folder, or make room and permission",
        )
    })
}
