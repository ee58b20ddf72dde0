//! From a candidate to a fitted model: the patch applied where the score expects it, places searched, everything refitted.

use crate::DiagnoseError;
use crate::effects::Variant;
use crate::model::{Model, Part};
use crate::probe::Candidate;
use crate::quadratic::Quadratic;
use crate::score::Score;
use crate::workshop::{Observer, Workshop, evaluate};
use gonio_fit::{Evaluate, Options, Space};
use gonio_scene::{Capture, EvaluationRequest, Output, Parameter};
use nalgebra::DVector;

/// Samples per pixel of a pattern search's evaluations.
const SEARCH_SAMPLES: u32 = 4;
/// A search ends after so many halvings of its step.
const HALVINGS: u32 = 5;

/// Fits `model` extended by a candidate; none where no place that was searched explains more than the model does.
///
/// # Errors
/// A patch that the format refuses, a fit that fails, a cancellation.
pub fn refit(
    model: &Model,
    candidate: &Candidate,
    score: &Score,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Option<Model>, DiagnoseError> {
    let mut files = model.files.clone();
    let mut capture = extended(&model.capture, &candidate.variant, &score.change, &mut files)?;
    if !candidate.variant.search.is_empty() {
        let mut farm = workshop.open(&capture, &files)?;
        let chi_square = search(&mut capture, &candidate.variant, options.seed, farm.as_mut(), observer)?;
        if chi_square >= model.fit.photos.iter().map(|p| p.chi_square).sum() {
            return Ok(None);
        }
    }
    let mut parts = model.parts.clone();
    parts.push(Part { effect: candidate.effect, variant: candidate.variant.clone() });
    Model::fit(&capture, files, parts, options, workshop, observer).map(Some)
}

/// The capture with a variant present, its numbers `change` from their nulls, and freed.
///
/// # Errors
/// A patch that the format refuses.
pub fn extended(
    capture: &Capture,
    variant: &Variant,
    change: &[f64],
    files: &mut Vec<(String, &'static [u8])>,
) -> Result<Capture, DiagnoseError> {
    let mut capture = capture.clone();
    variant.add_to(&mut capture, files);
    let known = capture.numbers();
    let mut values: Vec<(String, f64)> = Vec::new();
    for (direction, change) in variant.directions.iter().zip(change) {
        // A size that enters squared, or a weight, has no slope to follow at its very null.
        let least = if direction.one_sided && direction.most < 1e3 { 0.02 * direction.most } else { 0.0 };
        let change = if direction.one_sided { change.max(least) } else { *change };
        values.push((direction.name.clone(), direction.null + change));
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

/// Moves the searched numbers to where chi-square, with the candidate's own colours fitted along inside their bounds, is
/// least, and returns that chi-square: a pattern search (Hooke and Jeeves 1961), because the image of an edge far from its
/// place has no slope towards it. What else the model has stays where it is: a lamp that no wall has yet hidden would be
/// dimmed without end to make up for one that stands in the way.
fn search(
    capture: &mut Capture,
    variant: &Variant,
    seed: u64,
    farm: &mut dyn Evaluate,
    observer: &mut Observer<'_>,
) -> Result<f64, DiagnoseError> {
    let searched = |name: &str| variant.search.iter().any(|(n, _)| n == name);
    let space = Space::new(capture, &[])?;
    let columns: Vec<_> = space
        .columns(space.start())
        .into_iter()
        .filter(|c| !searched(&c.name) && variant.free.iter().any(|f| c.name.starts_with(f.as_str())))
        .filter(|c| c.name.starts_with("material.") || c.name.starts_with("light."))
        .collect();
    let photos: Vec<usize> = (0..capture.targets().count()).collect();
    let known = capture.numbers();
    let mut place: Vec<f64> = variant.search.iter().map(|(n, _)| known.get(n).map_or(0.0, |k| k.0)).collect();
    // Chi-square at a place, and what the candidate's colours are there.
    let mut loss = |place: &[f64]| -> Result<(f64, Vec<(String, f64)>), DiagnoseError> {
        let numbers = variant.search.iter().zip(place).map(|((n, _), x)| (n.clone(), *x)).collect();
        let request = EvaluationRequest {
            numbers,
            columns: columns.clone(),
            photos: photos.clone(),
            samples: SEARCH_SAMPLES,
            seed,
            output: Output::Statistics,
            ..EvaluationRequest::default()
        };
        let found = evaluate(farm, &request, observer)?;
        let all: Vec<(usize, f64)> = (0..columns.len()).map(|i| (i, 1.0)).collect();
        let each: Vec<Quadratic> = found.photos.iter().map(|p| Quadratic::new(p, &all)).collect();
        let mut chi_square: f64 = found.photos.iter().map(|p| p.gram.first().copied().unwrap_or(0.0)).sum();
        let mut colours = Vec::new();
        if let Some(q) = Quadratic::sum(&each) {
            let inside = |(c, x): (&Parameter, &f64)| x.clamp(c.range.min - c.value, c.range.max - c.value);
            let step = DVector::from_iterator(columns.len(), columns.iter().zip(q.solve().iter()).map(inside));
            chi_square += q.change(&step);
            colours = columns.iter().zip(&step).flat_map(|(c, x)| c.numbers(c.value + x).collect::<Vec<_>>()).collect();
        }
        Ok((chi_square, colours))
    };
    let (mut best, mut colours) = loss(&place)?;
    for halving in 0..=HALVINGS {
        let scale = 0.5_f64.powi(halving as i32);
        loop {
            // The best of all neighbours: the first that is better leads astray where many are.
            let mut next = None;
            for i in 0..place.len() {
                for sign in [1.0, -1.0] {
                    let mut there = place.clone();
                    there[i] += sign * scale * variant.search[i].1;
                    let (chi_square, found) = loss(&there)?;
                    if chi_square < best {
                        (best, colours) = (chi_square, found);
                        next = Some(there);
                    }
                }
            }
            match next {
                Some(there) => place = there,
                None => break,
            }
        }
    }
    let mut numbers: Vec<(String, f64)> =
        variant.search.iter().zip(&place).map(|((n, _), x)| (n.clone(), *x)).collect();
    numbers.extend(colours);
    capture.set_numbers(&numbers)?;
    Ok(best)
}
