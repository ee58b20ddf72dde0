//! What is different where measured reflectance, and no photo, is diagnosed.
//!
//! Only the material can be wrong. Evaluations are exact and cheap, so that nothing is taken from a quadratic that can be
//! computed: every variant of every effect is fitted, and every file is left out and predicted by a fit to the others.
//!
//! What differs most is what a gain must be. A measured surface is no sum of any catalogue's terms, neighbouring samples err
//! alike, and the stated noise is often a fraction of the misfit: at thousands of samples every further number is
//! "significant". So no significance decides, but how much an effect lowers the error on angles that it was not fitted to
//! (`Options::smallest_file_gain`, see there).

mod beside;
mod covariates;
mod left_out;
mod select;

pub(crate) use beside::Beside;
pub(crate) use covariates::pixels;
pub(crate) use left_out::left_out;
pub(crate) use select::select;

use crate::Options;
use crate::effects::Variant;
use crate::judge::Judgement;
use gonio_scene::Capture;

/// Keys of a material that need a place on an object, which a sample of reflectance does not have.
const OF_PLACES: [&str; 4] = ["albedo_variation", "roughness_variation", "bump", "scatter_distance"];

/// Whether a capture holds measured reflectance and no photo.
#[must_use]
pub(crate) fn alone(capture: &Capture) -> bool {
    capture.photos.is_empty() && !capture.reflectance.is_empty()
}

/// Whether samples of reflectance could show a variant: all of its numbers are a measured material's.
#[must_use]
pub(crate) fn shows(capture: &Capture, variant: &Variant) -> bool {
    let shown = |name: &str| {
        let mut parts = name.split('.');
        let (kind, material, key) = (parts.next(), parts.next(), parts.next());
        kind == Some("material")
            && capture.reflectance.iter().any(|r| Some(r.material.as_str()) == material)
            && key.is_some_and(|key| !OF_PLACES.contains(&key))
    };
    variant.directions.iter().all(|d| shown(&d.name))
}

/// How a fit to reflectance is done: exact evaluations need no samples, and are too cheap to stop early. One at a bound or
/// at an effect's null creeps on; after as many iterations nothing moves that matters.
#[must_use]
pub(crate) fn exact(options: &gonio_fit::Options) -> gonio_fit::Options {
    let max_iterations = Some(40);
    gonio_fit::Options { min_samples: 2, max_samples: 2, difference_samples: 2, max_iterations, ..options.clone() }
}

/// By which part the root of mean squares falls from one sum of squares to another.
#[must_use]
pub(crate) fn error_gain(before: f64, after: f64) -> f64 {
    if before > 0.0 { 1.0 - (after / before).max(0.0).sqrt() } else { 0.0 }
}

/// Why what the selection has found is not named; `None` where it is. Files that are held out decide where there are any,
/// those left out one at a time decided before.
#[must_use]
pub(crate) fn why_not(judgement: Option<&Judgement>, options: &Options) -> Option<String> {
    let judgement = judgement?;
    let gain = error_gain(judgement.before.reduced_chi_square, judgement.after.reduced_chi_square);
    (gain < options.smallest_file_gain).then(|| {
        let [gain, least] = [gain, options.smallest_file_gain].map(|g| 100.0 * g);
        format!("changes the error on held-out files by {:.1} %; {least:.0} % less would matter", -gain)
    })
}
