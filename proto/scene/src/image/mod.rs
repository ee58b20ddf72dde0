//! Images and masks, and the readers and writers of the file formats that they come in.

mod colour;
mod exr;
mod hdr;
mod limit;
mod mask;
mod raster;
mod remarks;
mod texture;
mod tiff;
mod write;

pub use mask::{Mask, read_mask};
pub use remarks::{Claims, claims};
pub use texture::{Curve, decode_texture, linear, read_texture};
pub use write::{encode_exr, encode_exr_channels, encode_png8, write_exr, write_exr_channels, write_png8};

use remarks::claims_of;
use std::path::Path;
use std::sync::Arc;

use crate::decoder::shielded;
use crate::error::{Result, SceneError};
use crate::files::Files;

/// A colour image.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue; row by row, the top row first, from the left. All finite in an image that was read.
    pub pixels: Vec<[f32; 3]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    OpenExr,
    Hdr,
    Png,
    Tiff,
    Jpeg,
}

/// Reads the image file `path`: OpenEXR, Radiance HDR, PNG, TIFF or JPEG, as both its extension and its first bytes say.
///
/// Integer values are divided by their largest (255, 65535 or 2^32 - 1) and no transfer curve is removed: how a value was
/// made is for the capture's `response` to say. Gray becomes three equal channels; alpha and other channels are passed over.
/// Of an OpenEXR, the display window is the image.
///
/// Colours are those of Rec. 709: where a Radiance HDR or an OpenEXR names other primaries, or XYZ, its values are
/// converted. Those of a Radiance HDR are divided by its EXPOSURE and COLORCORR, which makes them radiance again.
///
/// # Errors
/// The file cannot be read, is not of its extension's format, is truncated or damaged, has no unambiguous colour, has
/// samples of a type that no photo has, says that it is to be shown turned or mirrored, is larger than
/// [`MAX_SIDE`](crate::MAX_SIDE) or 1 GiB decoded, or has a pixel that is not finite.
pub fn read(files: &dyn Files, path: &str) -> Result<Image> {
    read_with_alpha(files, path).map(|(image, _)| image)
}

/// As [`read`], and which pixels count by the file's alpha channel: those above half of its largest value. `None` where
/// there is no such channel, or it is the same everywhere.
///
/// # Errors
/// As [`read`].
pub fn read_with_alpha(files: &dyn Files, path: &str) -> Result<(Image, Option<Vec<bool>>)> {
    let (format, bytes) = open(files, path)?;
    let (image, alpha) = shielded(path, || match format {
        Format::OpenExr => exr::read(path, &bytes),
        Format::Hdr => Ok((hdr::read(path, &bytes)?, None)),
        _ => {
            let raster = raster::read(path, format, &bytes)?;
            Ok((raster.image(), raster.alpha().map(|alpha| alpha.map(|value| value > mask::THRESHOLD).collect())))
        }
    })?;
    check_finite(path, &image)?;
    let alpha = alpha.filter(|bits: &Vec<bool>| bits.contains(&true) && bits.contains(&false));
    Ok((image, alpha))
}

/// The width and height in pixels of the image file `path`, without decoding its pixels.
///
/// # Errors
/// As [`read`], except for what only the pixels show.
pub fn dimensions(files: &dyn Files, path: &str) -> Result<(u32, u32)> {
    let (format, bytes) = open(files, path)?;
    shielded(path, || match format {
        Format::OpenExr => exr::dimensions(path, &bytes),
        _ => raster::dimensions(path, format, &bytes),
    })
}

fn open(files: &dyn Files, path: &str) -> Result<(Format, Arc<[u8]>)> {
    let extension = Path::new(path).extension().unwrap_or_default().to_ascii_lowercase();
    let format = match extension.to_str().unwrap_or_default() {
        "exr" => Format::OpenExr,
        "hdr" => Format::Hdr,
        "png" => Format::Png,
        "tif" | "tiff" => Format::Tiff,
        "jpg" | "jpeg" => Format::Jpeg,
        _ if is_raw(Path::new(path)) => {
            let mend = "make linear light of it by `gonio develop FILE --out FILE.exr`; what that cannot read, another program \
                        can: darktable, or rawpy to a linear 16-bit TIFF";
            return Err(SceneError::new(path, "is a camera's RAW file, which is prepared first", mend));
        }
        _ => {
            let mend = "use an OpenEXR, Radiance HDR, PNG, TIFF or JPEG file: .exr, .hdr, .png, .tif, .jpg";
            return Err(SceneError::new(path, "has no image format's extension", mend));
        }
    };
    let bytes = files.read(path)?;
    match format_of(&bytes) {
        Some(found) if found == format => Ok((format, bytes)),
        Some(found) => Err(SceneError::new(
            path,
            format!("is a {found:?} file by its first bytes, not what its extension says"),
            "rename it to the extension of its format",
        )),
        None if bytes.is_empty() => Err(SceneError::new(path, "is empty", "save the image again")),
        None => Err(SceneError::new(
            path,
            format!("does not begin as a {format:?} file"),
            "save it again, or give it the extension of its format",
        )),
    }
}

/// Whether a file's ending is that of a camera's RAW format.
#[must_use]
pub fn is_raw(path: &Path) -> bool {
    const ENDINGS: [&str; 33] = [
        "3fr", "ari", "arw", "cap", "cr2", "cr3", "crw", "dcr", "dcs", "dng", "erf", "fff", "gpr", "iiq", "k25", "kdc",
        "mdc", "mef", "mos", "mrw", "nef", "nrw", "orf", "pef", "raf", "raw", "rw2", "rwl", "sr2", "srf", "srw", "x3f",
        "eip",
    ];
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    ending.to_str().is_some_and(|ending| ENDINGS.contains(&ending))
}

fn format_of(bytes: &[u8]) -> Option<Format> {
    const MAGIC: [(&[u8], Format); 9] = [
        (&[0x76, 0x2f, 0x31, 0x01], Format::OpenExr),
        (b"#?RADIANCE", Format::Hdr),
        (b"#?RGBE", Format::Hdr),
        (b"\x89PNG\r\n\x1a\n", Format::Png),
        (b"II*\0", Format::Tiff),
        (b"MM\0*", Format::Tiff),
        // BigTIFF.
        (b"II+\0", Format::Tiff),
        (b"MM\0+", Format::Tiff),
        (&[0xff, 0xd8, 0xff], Format::Jpeg),
    ];
    MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|&(_, format)| format)
}

fn check_finite(path: &str, image: &Image) -> Result<()> {
    let broken = |pixel: &&[f32; 3]| !pixel.iter().all(|value| value.is_finite());
    let Some(first) = image.pixels.iter().position(|pixel| broken(&pixel)) else { return Ok(()) };
    let count = image.pixels.iter().filter(broken).count();
    let width = (image.width as usize).max(1);
    Err(SceneError::new(
        path,
        format!("has {count} pixels that are infinite or not a number, this one first"),
        "replace them by finite values, and leave them out by a mask",
    )
    .at(format!("pixel (column {}, row {})", first % width, first / width)))
}
