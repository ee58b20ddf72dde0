//! Images for the report: where the two sets differ most, and where an estimator typically does as well as it does.

use super::Estimated;
use crate::commands::evaluate;
use crate::failure::Failure;
use crate::report::PairPicture;
use gonio_scene::image::encode_png8;
use std::collections::BTreeMap;

/// Images of each kind.
const EACH: usize = 3;

/// Pairs of images with outlines of true and estimated poses: the worst of the real set, those whose errors differ most, and those
/// in the middle.
pub(super) fn chosen(real: &Estimated, synthetic: &Estimated) -> Result<Vec<PairPicture>, Failure> {
    let errors: BTreeMap<(u32, u32), f64> = synthetic.series.errors().collect();
    let pairs: Vec<((u32, u32), f64, f64)> =
        real.series.errors().filter_map(|(image, a)| errors.get(&image).map(|b| (image, a, *b))).collect();
    // A miss counts as one diameter: what is beyond is all the same.
    let apart = |(_, a, b): &((u32, u32), f64, f64)| (a.min(1.0) - b.min(1.0)).abs();
    let mut by_difference = pairs.clone();
    by_difference.sort_by(|a, b| apart(b).total_cmp(&apart(a)));
    let mut by_error = pairs;
    by_error.sort_by(|a, b| b.1.total_cmp(&a.1));
    let middle = by_error.len() / 2;
    let kinds = by_error
        .iter()
        .take(EACH)
        .chain(by_difference.iter().take(EACH))
        .chain(by_error.iter().skip(middle).take(EACH));
    let mut pictures: Vec<PairPicture> = Vec::new();
    let mut shown = std::collections::BTreeSet::new();
    for &((scene, image), error, other) in kinds {
        if shown.insert((scene, image)) {
            let (real, synthetic) = (outlined(real, scene, image)?, outlined(synthetic, scene, image)?);
            pictures.push(PairPicture { scene, image, real, synthetic, errors: [error, other] });
        }
    }
    Ok(pictures)
}

/// An image with its outlines, as PNG.
fn outlined(set: &Estimated, scene: u32, image: u32) -> Result<Vec<u8>, Failure> {
    let (width, height, pixels) = evaluate::outlined(&set.dataset, &set.models, &set.estimates, (scene, image))?;
    Ok(encode_png8(&format!("{scene:06}-{image:06}.png"), width, height, &pixels)?)
}
