//! A photograph as linear light, whatever kind of file it is.

use super::image;
use super::noise::usual;
use crate::failure::Failure;
use gonio_prepare::noise::Curve;
use gonio_prepare::raw::{Developed, Options, develop};
use gonio_scene::SceneError;
use gonio_scene::image::{Image, is_raw};
use std::path::Path;

/// A photograph in linear values.
pub(super) struct Light {
    /// Its values; a RAW file's in the colours that were asked for.
    pub image: Image,
    /// Pixels that are clipped.
    pub clipped: Vec<bool>,
    /// What else there is to say of a RAW file, its image taken out.
    pub raw: Option<Developed>,
}

/// A photo's value from this part of the largest on is clipped, where the largest is near the format's end.
const CLIPPED: f32 = 0.98;

/// Reads the photo; `curve` is how its values follow from light, `None` as is usual for its kind.
pub(super) fn light(path: &Path, curve: Option<Curve>, options: Options) -> Result<Light, Failure> {
    if is_raw(path) {
        let mut raw = raw(path, options)?;
        let image = std::mem::take(&mut raw.image);
        let clipped = std::mem::take(&mut raw.clipped);
        return Ok(Light { image, clipped, raw: Some(raw) });
    }
    let mut image = image(path)?;
    let curve = curve.unwrap_or_else(|| usual(path, &image));
    let most = image.pixels.iter().flatten().fold(0.0_f32, |a, b| a.max(*b));
    let limit = if most >= 0.9 { CLIPPED * most } else { f32::INFINITY };
    let clipped = image.pixels.iter().map(|pixel| pixel.iter().any(|value| *value >= limit)).collect();
    image.pixels.iter_mut().flatten().for_each(|value| *value = curve.light(f64::from(*value)) as f32);
    Ok(Light { image, clipped, raw: None })
}

/// A RAW file, developed.
pub(super) fn raw(path: &Path, options: Options) -> Result<Developed, Failure> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|error| {
        SceneError::new(&name, format!("cannot be read: {error}"), "correct the path, or its permissions")
    })?;
    Ok(develop(&name, &bytes, options)?)
}
