//! Masks: which pixels of a photo count.

use super::raster::{Raster, Samples};
use super::{Format, open, raster};
use crate::decoder::shielded;
use crate::error::{Result, SceneError};
use crate::files::Files;

/// Which pixels of an image count.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Mask {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Whether a pixel counts; row by row, the top row first, from the left.
    pub bits: Vec<bool>,
}

/// A pixel counts above this share of the largest value: from 128 of 255 on.
pub(super) const THRESHOLD: f32 = 0.5;

/// Reads the mask file `path`: a gray PNG, TIFF or JPEG in which a pixel counts where its value is above 127 of 255. Three
/// equal colour channels pass for gray. Where all of them are the same everywhere, an alpha channel that varies is the
/// mask; where both vary, they must agree.
///
/// # Errors
/// As [`super::read`]; the file has colours or floating-point values; gray and alpha disagree; or all of its values are
/// small, so that it seems to have another scale (0 and 1).
pub fn read_mask(files: &dyn Files, path: &str) -> Result<Mask> {
    let (format, bytes) = open(files, path)?;
    let mend = "save the mask as an 8-bit gray PNG, 255 where a pixel counts and 0 elsewhere";
    if matches!(format, Format::OpenExr | Format::Hdr) {
        return Err(SceneError::new(
            path,
            "has floating-point values, and a mask counts by the value 127 of 255",
            mend,
        ));
    }
    let decoded = shielded(path, || raster::read(path, format, &bytes))?;
    if matches!(decoded.samples, Samples::F32(_)) {
        return Err(SceneError::new(path, "has a pixel type that a mask cannot have", mend));
    }
    let columns = (decoded.width as usize).max(1);
    let place = |pixel: usize| format!("pixel (column {}, row {})", pixel % columns, pixel / columns);
    let gray = gray(&decoded).map_err(|first| {
        SceneError::new(path, "has a colour, so that it is not clear what counts", mend).at(place(first))
    })?;
    let alpha: Option<Vec<f32>> = decoded.alpha().map(Iterator::collect);
    let bits = |values: &[f32]| values.iter().map(|value| *value > THRESHOLD).collect::<Vec<_>>();
    let values = match alpha {
        Some(alpha) if varies(&alpha) && varies(&gray) => {
            let (by_gray, by_alpha) = (bits(&gray), bits(&alpha));
            if let Some(first) = by_gray.iter().zip(&by_alpha).position(|(gray, alpha)| gray != alpha) {
                let problem = "has a gray value and an alpha that disagree, so that it is not clear what counts";
                return Err(SceneError::new(path, problem, mend).at(place(first)));
            }
            gray
        }
        Some(alpha) if varies(&alpha) => alpha,
        _ => gray,
    };
    let largest = values.iter().copied().fold(0.0, f32::max);
    if largest > 0.0 && largest <= THRESHOLD {
        let shown = (f64::from(largest) * 255e3).round() / 1e3;
        let problem = format!("has the largest value {shown} of 255, so that no pixel counts");
        return Err(SceneError::new(path, problem, mend));
    }
    Ok(Mask { width: decoded.width, height: decoded.height, bits: bits(&values) })
}

fn varies(values: &[f32]) -> bool {
    values.windows(2).any(|pair| pair.first() != pair.last())
}

/// One value per pixel, or the number of the first pixel that is not gray.
fn gray(raster: &Raster) -> std::result::Result<Vec<f32>, usize> {
    let value = |pixel: usize| {
        let first = raster.value(pixel, 0);
        let equal = raster.channels < 3 || (1..3).all(|channel| raster.value(pixel, channel) == first);
        if equal { Ok(first) } else { Err(pixel) }
    };
    (0..raster.pixels()).map(value).collect()
}
