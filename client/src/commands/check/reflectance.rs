//! Measured reflectance.

use crate::progress::count;
use gonio_scene::capture::{Reflectance, Role};
use gonio_scene::files::Files;
use gonio_scene::reflectance;
use gonio_scene::{Capture, SceneError};
use serde::Serialize;

/// More samples below zero by ten standard deviations than this share are suspicious.
const NEGATIVE: f64 = 0.01;

/// One file of measured reflectance.
#[derive(Debug, Serialize)]
pub(super) struct ReflectanceSummary {
    pub name: String,
    pub material: String,
    /// "fit" or "held-out".
    pub role: &'static str,
    pub samples: u64,
    /// Mean BRDF per channel, 1/sr.
    pub mean: [f64; 3],
}

/// Looks at every file of samples.
pub(super) fn look(
    capture: &Capture,
    files: &dyn Files,
    errors: &mut Vec<SceneError>,
    warnings: &mut Vec<String>,
) -> Vec<ReflectanceSummary> {
    let mut summaries = Vec::new();
    for reflectance in &capture.reflectance {
        match reflectance::read(files, reflectance) {
            Ok((image, counts)) => {
                let samples: Vec<[f32; 3]> =
                    image.pixels.iter().zip(counts).filter(|(_, counts)| *counts).map(|(v, _)| *v).collect();
                warn(reflectance, &samples, warnings);
                summaries.push(summarise(reflectance, &samples));
            }
            Err(error) => errors.push(error),
        }
    }
    summaries
}

fn summarise(reflectance: &Reflectance, samples: &[[f32; 3]]) -> ReflectanceSummary {
    let number = count(samples.len() as u64).max(1.0);
    ReflectanceSummary {
        name: reflectance.name().to_owned(),
        material: reflectance.material.clone(),
        role: if reflectance.role == Role::HeldOut { "held-out" } else { "fit" },
        samples: samples.len() as u64,
        mean: std::array::from_fn(|c| samples.iter().map(|v| f64::from(v[c])).sum::<f64>() / number),
    }
}

fn warn(reflectance: &Reflectance, samples: &[[f32; 3]], warnings: &mut Vec<String>) {
    let negative = samples.iter().flatten().filter(|v| f64::from(**v) < -10.0 * reflectance.noise).count();
    if count(negative as u64) > NEGATIVE * 3.0 * count(samples.len() as u64) {
        warnings.push(format!("{}: {negative} values are far below zero, which no surface reflects", reflectance.file));
    }
}
