//! Radiance HDR: what its header says of its values. The pixels are the `image` crate's to decode.
//!
//! Source of the keys: Ward, "Radiance File Formats"; a key that stands there several times counts by its product.

use std::borrow::Cow;

use super::colour::{Primaries, convert, xyz_to_rec709};
use super::{Format, Image, raster};
use crate::error::{Result, SceneError};

const XYZ: &[u8] = b"32-bit_rle_xyze";
const RGB: &[u8] = b"32-bit_rle_rgbe";

/// A header ends at its first empty line; one longer than this is none.
const LONGEST: usize = 1 << 16;

/// What the file's values are to be divided by, and whose colours they are.
struct Header {
    divisor: [f64; 3],
    primaries: Option<Primaries>,
    xyz: bool,
}

/// Reads an image as radiance in Rec. 709: divided by its exposure and colour correction.
pub(super) fn read(path: &str, bytes: &[u8]) -> Result<Image> {
    let header = header(path, bytes)?;
    let mut image = raster::read(path, Format::Hdr, &as_rgb(bytes))?.image();
    if header.divisor != [1.0; 3] {
        #[allow(clippy::cast_possible_truncation)]
        for pixel in &mut image.pixels {
            *pixel = std::array::from_fn(|channel| (f64::from(pixel[channel]) / header.divisor[channel]) as f32);
        }
    }
    let matrix = if header.xyz {
        xyz_to_rec709()
    } else {
        let Some(primaries) = header.primaries.filter(|primaries| !primaries.is_rec709()) else { return Ok(image) };
        primaries.to_rec709()
    };
    let matrix = matrix.ok_or_else(|| {
        SceneError::new(path, "are primaries that span no colours", "save the image again, in Rec. 709").at("PRIMARIES")
    })?;
    convert(&mut image, matrix);
    Ok(image)
}

/// The same file with a header that the decoder knows: XYZ and RGB pixels are coded alike.
pub(super) fn as_rgb(bytes: &[u8]) -> Cow<'_, [u8]> {
    let head = bytes.get(..bytes.len().min(LONGEST)).unwrap_or_default();
    let end = head.windows(2).position(|pair| pair == b"\n\n").unwrap_or(0);
    match head.windows(XYZ.len()).position(|word| word == XYZ).filter(|at| *at < end) {
        Some(at) => {
            let mut bytes = bytes.to_vec();
            if let Some(word) = bytes.get_mut(at..at + XYZ.len()) {
                word.copy_from_slice(RGB);
            }
            Cow::Owned(bytes)
        }
        None => Cow::Borrowed(bytes),
    }
}

fn header(path: &str, bytes: &[u8]) -> Result<Header> {
    let mut header = Header { divisor: [1.0; 3], primaries: None, xyz: false };
    let head = bytes.get(..bytes.len().min(LONGEST)).unwrap_or_default();
    for line in head.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).take_while(|line| !line.is_empty()) {
        let mut parts = line.splitn(2, |&byte| byte == b'=');
        let (Some(key), Some(value)) = (parts.next(), parts.next()) else { continue };
        let value = String::from_utf8_lossy(value);
        let key = String::from_utf8_lossy(key).trim().to_owned();
        let numbers = |count: usize| {
            let numbers: Option<Vec<f64>> = value.split_whitespace().map(|word| word.parse().ok()).collect();
            numbers
                .filter(|numbers| numbers.len() == count && numbers.iter().all(|number| number.is_finite()))
                .ok_or_else(|| {
                    let problem = format!("is {}, not {count} numbers", value.trim());
                    SceneError::new(path, problem, "correct the file's header, or save the image again").at(&key)
                })
        };
        match key.as_str() {
            "FORMAT" => header.xyz = value.trim().as_bytes() == XYZ,
            "EXPOSURE" | "COLORCORR" => {
                let found = numbers(if key == "EXPOSURE" { 1 } else { 3 })?;
                for (divisor, factor) in header.divisor.iter_mut().zip(found.iter().cycle()) {
                    *divisor *= factor;
                }
                if !header.divisor.iter().all(|divisor| divisor.is_finite() && *divisor > 0.0) {
                    let problem = format!("is {}, which no value can be divided by", value.trim());
                    let mend = "correct the file's header, or save the image again";
                    return Err(SceneError::new(path, problem, mend).at(&key));
                }
            }
            "PRIMARIES" => {
                let found = numbers(8)?;
                let (pairs, _) = found.as_chunks::<2>();
                header.primaries = pairs.try_into().ok().map(Primaries);
            }
            _ => {}
        }
    }
    Ok(header)
}
