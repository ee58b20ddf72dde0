//! What an image file says of its values beyond what reading them uses.

use super::colour::Primaries;
use super::{Format, exr, open};
use crate::decoder::shielded;
use crate::error::Result;
use crate::files::Files;

/// What a file claims of its values, to be held against what a capture says of its sensor.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Claims {
    /// A PNG's `gAMA`: values are radiance to this power, 1 for linear ones, 0.45455 for those of a display.
    pub gamma: Option<f64>,
    /// A PNG's `sRGB`: values have sRGB's curve and colours.
    pub srgb: bool,
    /// A PNG's `cHRM` names primaries other than those of Rec. 709.
    pub other_primaries: bool,
    /// An OpenEXR's `whiteLuminance`: cd/m^2 that the value 1 stands for.
    pub white_luminance: Option<f64>,
}

/// The size of a PNG's chunk without its data: length, name and checksum.
const FRAME: usize = 12;

/// Reads what the image file `path` claims of its values; nothing for formats that claim nothing.
///
/// # Errors
/// As [`super::dimensions`].
pub fn claims(files: &dyn Files, path: &str) -> Result<Claims> {
    let (format, bytes) = open(files, path)?;
    claims_of(path, format, &bytes)
}

/// As [`claims`], from a file's bytes.
pub(super) fn claims_of(path: &str, format: Format, bytes: &[u8]) -> Result<Claims> {
    match format {
        Format::OpenExr => {
            let luminance = shielded(path, || exr::white_luminance(path, bytes))?;
            Ok(Claims { white_luminance: luminance.map(f64::from), ..Claims::default() })
        }
        Format::Png => Ok(png(bytes.get(8..).unwrap_or_default())),
        _ => Ok(Claims::default()),
    }
}

/// The chunks before the pixels: PNG (third edition), section 11.3.2.
fn png(mut rest: &[u8]) -> Claims {
    let mut claims = Claims::default();
    let hundred_thousandths = |bytes: &[u8]| -> Vec<f64> {
        bytes.as_chunks::<4>().0.iter().map(|bytes| f64::from(u32::from_be_bytes(*bytes)) / 1e5).collect()
    };
    while let Some((head, _)) = rest.split_first_chunk::<8>() {
        let [a, b, c, d, name @ ..] = *head;
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        let data = rest.get(8..8usize.saturating_add(length)).unwrap_or_default();
        match &name {
            b"gAMA" => claims.gamma = hundred_thousandths(data).first().copied(),
            b"sRGB" => claims.srgb = true,
            b"cHRM" => {
                // White stands first there.
                if let [wx, wy, rx, ry, gx, gy, bx, by] = *hundred_thousandths(data).as_slice() {
                    let primaries = Primaries([[rx, ry], [gx, gy], [bx, by], [wx, wy]]);
                    claims.other_primaries = !primaries.is_rec709();
                }
            }
            b"IDAT" => break,
            _ => {}
        }
        rest = rest.get(length.saturating_add(FRAME)..).unwrap_or_default();
    }
    claims
}
