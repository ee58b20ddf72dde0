//! What an image's header may ask for, checked before anything is decoded.

use crate::MAX_SIDE;
use crate::error::{Result, SceneError};

/// The most bytes that decoding an image may take.
pub(super) const MAX_BYTES: u64 = 1 << 30;

/// No lossless compression in use makes an image smaller than this fraction: deflate reaches 1032, LZW 1365. A header
/// that asks for more belongs to a damaged file, which would cost its announced size before anyone notices.
const MAX_RATIO: u64 = 2048;

/// Bytes that any file may ask for, whatever its size.
const FREE_BYTES: u64 = 1 << 16;

/// Checks the size in pixels, and the bytes that `decoder` needs for them, against the limits and the file's own size.
///
/// # Errors
/// The image has no pixels, is too large, or cannot fit into a file of `file_bytes` bytes.
pub(super) fn check(path: &str, (width, height): (u32, u32), decoder: u64, file_bytes: usize) -> Result<()> {
    let refuse = |problem: String, mend: &str| Err(SceneError::new(path, problem, mend).at("size"));
    if width == 0 || height == 0 {
        return refuse(format!("is {width} x {height} pixels"), "save the image again");
    }
    if width > MAX_SIDE || height > MAX_SIDE {
        return refuse(
            format!("is {width} x {height} pixels, above the limit of {MAX_SIDE} a side"),
            "crop or shrink the image, and its camera with it",
        );
    }
    let pixels = u64::from(width) * u64::from(height) * 12;
    let bytes = decoder.max(pixels);
    if bytes > MAX_BYTES {
        return refuse(
            format!("takes {bytes} bytes when decoded, above the limit of {MAX_BYTES}"),
            "crop or shrink the image, or save fewer channels",
        );
    }
    if decoder > FREE_BYTES.saturating_add(MAX_RATIO.saturating_mul(file_bytes as u64)) {
        return refuse(
            format!("announces {width} x {height} pixels, which its {file_bytes} bytes cannot hold"),
            "the file is truncated or its header damaged: save it again",
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::check;

    #[test]
    fn black_images_pass_and_impossible_ones_do_not() {
        assert!(check("a.png", (4096, 4096), 4096 * 4096 * 3, 4096 * 4096 * 3 / 1032).is_ok());
        assert!(check("a.png", (16384, 4096), 16384 * 4096, 1000).is_err());
        assert!(check("a.png", (0, 4), 0, 1000).is_err());
        assert!(check("a.png", (16385, 1), 16385, 1_000_000).is_err());
        assert!(check("a.png", (16384, 16384), 16384 * 16384, 1 << 30).is_err());
    }
}
