//! What is different where measured reflectance, and no photo, is diagnosed.
//!
//! Only the material can be wrong. Evaluations are exact and cheap, so that nothing is taken from a quadratic that can be
//! computed: every variant of every effect is fitted, and every file is left out and predicted by a fit to the others.
//!
//! What differs most is what a gain must be. A measured surface is no sum of any catalogue's terms, neighbouring samples err
//! alike, and the stated noise is often a fraction of the misfit: at thousands of samples every further number is
//! "significant". So no significance decides, but how much an effect lowers the error on angles that it was not fitted to
//! (`Options::smallest_file_gain`, see there).

mod covariates;
mod left_out;

pub(crate) use covariates::pixels;
pub(crate) use left_out::left_out;

use crate::effects::Variant;
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
