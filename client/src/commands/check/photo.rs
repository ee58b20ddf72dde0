//! Photographs and masks.

use crate::progress::count;
use gonio_scene::capture::{Photo, Response, Role};
use gonio_scene::files::Files;
use gonio_scene::image::{claims, read_mask};
use gonio_scene::{Capture, Photograph, SceneError};
use serde::Serialize;

/// A photo whose pixels count for less than this share is suspicious.
const FEW: f64 = 0.005;
/// More of the mask clipped than this is suspicious.
const MUCH_CLIPPED: f64 = 0.1;
/// More pixels at one photo's largest value than this look like clipping.
const PILED_UP: f64 = 0.005;
/// A radiance so many times that of the median photo is suspicious.
const ODD: f64 = 20.0;

/// One photo.
#[derive(Debug, Serialize)]
pub(super) struct PhotoSummary {
    pub name: String,
    /// "fit" or "held-out".
    pub role: &'static str,
    pub width: u32,
    pub height: u32,
    /// Pixels inside the mask that are not clipped.
    pub counted: u64,
    /// Pixels inside the mask that are clipped.
    pub clipped: u64,
    /// Mean value of the pixels that count, per channel.
    pub mean: [f64; 3],
}

/// Looks at every photo and mask.
pub(super) fn look(
    capture: &Capture,
    files: &dyn Files,
    errors: &mut Vec<SceneError>,
    warnings: &mut Vec<String>,
) -> Vec<PhotoSummary> {
    let mut summaries = Vec::new();
    for photo in &capture.photos {
        match Photograph::load(capture, photo, files) {
            Ok(photograph) => {
                let summary = summarise(photo, &photograph);
                warn(capture, photo, &photograph, &summary, warnings);
                summaries.push((photo.factor(), summary));
            }
            Err(error) => {
                // A photo that cannot be read hides its mask's errors.
                let mask = photo.mask.as_ref().and_then(|mask| read_mask(files, mask).err());
                errors.extend(mask);
                errors.push(error);
            }
        }
    }
    warn_of_exposures(&summaries, warnings);
    summaries.into_iter().map(|(_, summary)| summary).collect()
}

/// A display's curve raises radiance to about this power.
const DISPLAY: f64 = 0.45455;

/// Holds what the files say of their values against `[sensor]`.
pub(super) fn look_at_claims(capture: &Capture, files: &dyn Files, warnings: &mut Vec<String>) {
    let linear = capture.sensor.response == Response::Linear;
    let mut told = 0;
    for photo in &capture.photos {
        let file = &photo.file;
        let lower = file.to_ascii_lowercase();
        let mut say = Vec::new();
        if linear && [".jpg", ".jpeg"].iter().any(|ending| lower.ends_with(ending)) {
            say.push("is a JPEG, whose values have a display's curve, and sensor.response is \"linear\"".to_owned());
        }
        // What cannot be read is said where its pixels are.
        let claims = claims(files, file).unwrap_or_default();
        let coded = claims.srgb || claims.gamma.is_some_and(|gamma| (gamma - DISPLAY).abs() < 0.05);
        if linear && coded {
            say.push("says that its values have a display's curve, and sensor.response is \"linear\"".to_owned());
        }
        if let Some(gamma) = claims.gamma.filter(|gamma| !linear && (gamma - 1.0).abs() < 0.05) {
            say.push(format!("says that its values are linear (gamma {gamma}), and sensor.response is not"));
        }
        if claims.other_primaries {
            say.push("names primaries other than those of Rec. 709, and its values are taken for Rec. 709".to_owned());
        }
        if let Some(luminance) = claims.white_luminance.filter(|luminance| (luminance - 1.0).abs() > 1e-6) {
            say.push(format!("says that 1 stands for {luminance} cd/m^2, and its values are taken as they stand"));
        }
        told += usize::from(!say.is_empty());
        // Photos of one camera say the same.
        if told <= 3 {
            warnings.extend(say.iter().map(|text| format!("{file}: {text}")));
        }
    }
    if told > 3 {
        warnings.push(format!("{} more photos say of their values what [sensor] does not", told - 3));
    }
}

fn summarise(photo: &Photo, photograph: &Photograph) -> PhotoSummary {
    let counting = || photograph.image.pixels.iter().zip(&photograph.counts).filter(|(_, counts)| **counts);
    let counted = counting().count() as u64;
    let mut mean = [0.0; 3];
    for (pixel, _) in counting() {
        for (sum, value) in mean.iter_mut().zip(pixel) {
            *sum += f64::from(*value);
        }
    }
    PhotoSummary {
        name: photo.name().to_owned(),
        role: if photo.role == Role::HeldOut { "held-out" } else { "fit" },
        width: photograph.image.width,
        height: photograph.image.height,
        counted,
        clipped: photograph.clipped as u64,
        mean: mean.map(|sum| sum / count(counted).max(1.0)),
    }
}

fn warn(capture: &Capture, photo: &Photo, photograph: &Photograph, summary: &PhotoSummary, warnings: &mut Vec<String>) {
    let file = &photo.file;
    let pixels = count(photograph.image.pixels.len() as u64).max(1.0);
    let (counted, clipped) = (count(summary.counted), count(summary.clipped));
    if counted / pixels < FEW {
        warnings.push(format!("{file}: only {} of its pixels count; is the mask inverted?", summary.counted));
    }
    if clipped > MUCH_CLIPPED * (counted + clipped) {
        let share = 100.0 * clipped / (counted + clipped);
        warnings.push(format!("{file}: {share:.0} % of the masked pixels are clipped; a shorter exposure says more"));
    }
    let brightest = summary.mean.iter().copied().fold(f64::MIN, f64::max);
    if brightest < capture.sensor.read_noise {
        warnings.push(format!("{file}: its mean value is below the sensor's read noise: it is all but black"));
    }
    if capture.sensor.saturation.is_none() && !file.to_ascii_lowercase().ends_with(".exr") {
        let values = || photograph.image.pixels.iter().flatten();
        let largest = values().copied().fold(0.0, f32::max);
        let piled = values().filter(|value| **value >= largest).count() as u64;
        if largest > 0.0 && count(piled) > PILED_UP * 3.0 * pixels {
            warnings.push(format!(
                "{file}: {piled} values are the largest one, {largest}: it seems to be clipped; set sensor.saturation"
            ));
        }
    }
    let dark: Vec<&f32> = photograph.image.pixels.iter().flatten().filter(|value| **value < 0.0).collect();
    if let Some(lowest) = dark.iter().map(|value| **value).reduce(f32::min)
        && f64::from(lowest) < -10.0 * capture.sensor.read_noise
    {
        warnings.push(format!("{file}: has values down to {lowest}, far below what read noise explains"));
    }
}

/// Photos of one scene differ in radiance, but not by orders of magnitude.
fn warn_of_exposures(summaries: &[(f64, PhotoSummary)], warnings: &mut Vec<String>) {
    let radiance = |(factor, s): &(f64, PhotoSummary)| s.mean.iter().sum::<f64>() / 3.0 / factor;
    let mut all: Vec<f64> = summaries.iter().map(radiance).filter(|r| *r > 0.0).collect();
    all.sort_by(f64::total_cmp);
    let Some(median) = all.get(all.len() / 2).copied() else { return };
    for entry in summaries {
        let ratio = radiance(entry) / median;
        if ratio > 0.0 && !(1.0 / ODD..=ODD).contains(&ratio) {
            warnings.push(format!(
                "capture.toml: photo.{}.exposure: its mean value over exposure is {ratio:.2e} times the median photo's; is the exposure right?",
                entry.1.name
            ));
        }
    }
}
