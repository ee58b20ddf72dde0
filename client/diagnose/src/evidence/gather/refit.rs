//! From a candidate to a fitted model: the patch applied where the score expects it, places searched, everything refitted.

use crate::DiagnoseError;
use crate::effects::Variant;
use crate::evidence::gather::finer::refined;
use crate::evidence::gather::model::{Model, Part};
use crate::evidence::gather::probe::Candidate;
use crate::evidence::gather::score::Score;
use crate::evidence::gather::search::{Aim, search};
use crate::overlay::AddedFile;
use crate::policy::Policy;
use crate::workshop::{Observer, Workshop};
use gonio_fit::Options;
use gonio_scene::Capture;

/// Searches, each with all else fitted anew to where the last has ended, at most.
const ROUNDS: u32 = 3;
/// A round that leaves more than this part of chi-square was the last.
const WORTHWHILE: f64 = 0.9;

/// Fits `model` extended by a candidate; none where no place that was searched explains more than the model does. ///
/// # Errors
/// A patch that the format refuses, a fit that fails, a cancellation.
pub fn refit(
    model: &Model,
    (candidate, score): (&Candidate, &Score),
    policy: &Policy,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Option<Model>, DiagnoseError> {
    let variant = &candidate.variant;
    let mut files = model.files.clone();
    // A quadratic that some direction is lost to noise in leads astray: the fit begins at the null, then.
    let determined = score.freedom >= variant.directions.len() || !variant.search.is_empty();
    let change = if determined { score.change.clone() } else { vec![0.0; score.change.len()] };
    let mut capture = extended(&model.capture, variant, &change, &mut files)?;
    let mut parts = model.parts.clone();
    parts.push(Part { effect: candidate.effect, variant: variant.as_fine_as(0) });
    for name in variant.finer.iter().flatten() {
        capture.fit.parameters.retain(|free| free != name);
    }
    if !variant.finer.is_empty() {
        let coarse = Model::fit(&capture, files, parts, options, workshop, observer)?;
        return refined(coarse, variant, policy, options, workshop, observer).map(Some);
    }
    if variant.search.is_empty() {
        return Model::fit(&capture, files, parts, options, workshop, observer).map(Some);
    }
    // A place that was searched stays until the model is known to be the one to keep: each of its numbers costs a fit two
    // renders an iteration.
    capture.fit.parameters.retain(|name| !variant.searched().contains(name.as_str()));
    let before = loss(model);
    let mut found: Option<Model> = None;
    for round in 0..ROUNDS {
        let aim = Aim { round, seed: options.seed };
        search(&mut capture, variant, aim, &files, workshop, observer)?;
        let fitted = Model::fit(&capture, files.clone(), parts.clone(), options, workshop, observer)?;
        capture = fitted.capture.clone();
        let last = found.as_ref().map_or(before, loss);
        let here = loss(&fitted);
        if here < last {
            found = Some(fitted);
        }
        if here > WORTHWHILE * last {
            break;
        }
    }
    Ok(found)
}

/// Loss of the fitted photos.
fn loss(model: &Model) -> f64 {
    model.fit.photos.iter().map(gonio_scene::PhotoStatistics::loss).sum()
}

/// The capture with a variant present, its numbers `change` from their nulls, and freed.
///
/// # Errors
/// A patch that the format refuses.
pub fn extended(
    capture: &Capture,
    variant: &Variant,
    change: &[f64],
    files: &mut Vec<AddedFile>,
) -> Result<Capture, DiagnoseError> {
    let mut capture = capture.clone();
    variant.add_to(&mut capture, files);
    let known = capture.numbers();
    let mut values: Vec<(String, f64)> = Vec::new();
    for (direction, change) in variant.directions.iter().zip(change) {
        // A size that enters squared, or a weight, has no slope to follow at its very null.
        let least = if direction.one_sided && direction.most < 1e3 { 0.02 * direction.most } else { 0.0 };
        let change = if direction.one_sided { change.max(least) } else { *change };
        values.push((direction.moves().to_owned(), direction.null + change));
        if direction.of_photo.is_some() {
            continue;
        }
        let moved = direction.along.iter().filter(|(n, _)| !variant.settings.iter().any(|(s, _)| s == n));
        values.extend(moved.map(|(n, ratio)| (n.clone(), known.get(n).map_or(0.0, |k| k.0) + ratio * change)));
    }
    for (name, value) in &variant.settings {
        values.retain(|(n, _)| n != name);
        values.push((name.clone(), *value));
    }
    for (name, value) in &mut values {
        if let Some((_, range)) = known.get(name) {
            *value = value.clamp(range.min, range.max);
        }
    }
    capture.set_numbers(&values)?;
    for name in &variant.free {
        if !capture.fit.parameters.contains(name) {
            capture.fit.parameters.push(name.clone());
        }
    }
    capture.fit.gray.extend(variant.gray.iter().cloned());
    Ok(capture)
}
