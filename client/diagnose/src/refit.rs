//! From a candidate to a fitted model: the patch applied where the score expects it, places searched, everything refitted.

use crate::effects::Variant;
use crate::finer::refined;
use crate::model::{Model, Part};
use crate::probe::Candidate;
use crate::quadratic::Quadratic;
use crate::score::Score;
use crate::workshop::{Observer, Workshop, evaluate, tell};
use crate::{DiagnoseError, DiagnoseEvent};
use gonio_fit::{Evaluate, Options, Space};
use gonio_scene::{Capture, EvaluationRequest, Output, Parameter};
use nalgebra::DVector;

/// Samples per pixel of a pattern search's evaluations.
const SEARCH_SAMPLES: u32 = 4;
/// A search ends after so many halvings of its step.
const HALVINGS: u32 = 5;
/// Searches, each with all else fitted anew to where the last has ended, at most.
const ROUNDS: u32 = 3;
/// A round that leaves more than this part of chi-square was the last.
const WORTHWHILE: f64 = 0.9;
/// Sweeps over all numbers with one step, at most.
const SWEEPS: u32 = 30;
/// Steps that a parabola may move a number by.
const REACH: f64 = 2.0;

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
    let variant = &candidate.variant;
    let mut files = model.files.clone();
    let mut capture = extended(&model.capture, variant, &score.change, &mut files)?;
    let mut parts = model.parts.clone();
    parts.push(Part { effect: candidate.effect, variant: variant.as_fine_as(0) });
    for name in variant.finer.iter().flatten() {
        capture.fit.parameters.retain(|free| free != name);
    }
    if !variant.finer.is_empty() {
        let coarse = Model::fit(&capture, files, parts, options, workshop, observer)?;
        return refined(coarse, variant, options, workshop, observer).map(Some);
    }
    if variant.search.is_empty() {
        return Model::fit(&capture, files, parts, options, workshop, observer).map(Some);
    }
    // A place that was searched stays until the model is known to be the one to keep: each of its numbers costs a fit two
    // renders an iteration.
    capture.fit.parameters.retain(|name| !variant.search.iter().any(|(n, _)| n == name));
    let before = chi_square(model);
    let mut found: Option<Model> = None;
    for round in 0..ROUNDS {
        let mut farm = workshop.open(&capture, &files)?;
        search(&mut capture, variant, round, options.seed, farm.as_mut(), observer)?;
        let fitted = Model::fit(&capture, files.clone(), parts.clone(), options, workshop, observer)?;
        capture = fitted.capture.clone();
        let last = found.as_ref().map_or(before, chi_square);
        let here = chi_square(&fitted);
        if here < last {
            found = Some(fitted);
        }
        if here > WORTHWHILE * last {
            break;
        }
    }
    Ok(found)
}

/// Chi-square of the fitted photos.
fn chi_square(model: &Model) -> f64 {
    model.fit.photos.iter().map(|p| p.chi_square).sum()
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
/// least: a pattern search (Hooke and Jeeves 1961) that also tries the parabolas' vertices, because the image of an edge far from its
/// place has no slope towards it. What else the model has stays where it is: a lamp that no wall has yet hidden would be
/// dimmed without end to make up for one that stands in the way. The first step is the variant's over 2^`round`.
fn search(
    capture: &mut Capture,
    variant: &Variant,
    round: u32,
    seed: u64,
    farm: &mut dyn Evaluate,
    observer: &mut Observer<'_>,
) -> Result<(), DiagnoseError> {
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
    let mut loss = |place: &[f64], observer: &mut Observer<'_>| -> Result<(f64, Vec<(String, f64)>), DiagnoseError> {
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
    let (mut best, mut colours) = loss(&place, observer)?;
    for halving in round..=HALVINGS {
        let text = format!("searching its place in steps of 1/{}, chi-square {best:.0}", 1_u32 << halving);
        tell(observer, &DiagnoseEvent::Stage { text })?;
        let scale = 0.5_f64.powi(halving as i32);
        for _ in 0..SWEEPS {
            // The best of all neighbours: the first that is better leads astray where many are.
            let mut next = None;
            let (from, mut vertex) = (best, place.clone());
            for i in 0..place.len() {
                let step = scale * variant.search[i].1;
                let mut around = [0.0; 2];
                for (chi_square, sign) in around.iter_mut().zip([1.0, -1.0]) {
                    let mut there = place.clone();
                    there[i] += sign * step;
                    let (found, with) = loss(&there, observer)?;
                    *chi_square = found;
                    if found < best {
                        (best, colours) = (found, with);
                        next = Some(there);
                    }
                }
                vertex[i] += step * parabola(around[1], from, around[0]);
            }
            // All numbers at once, each to the vertex of the parabola through its two neighbours: with the first, long steps it would
            // leap over edges.
            if halving > 0 {
                let (found, with) = loss(&vertex, observer)?;
                if found < best {
                    (best, colours) = (found, with);
                    next = Some(vertex);
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
    Ok(capture.set_numbers(&numbers)?)
}

/// Where the parabola through (-1, `below`), (0, `here`), (1, `above`) is least, at most [`REACH`] away; where it has no
/// minimum, that far towards the lower side, or nowhere if both are higher.
fn parabola(below: f64, here: f64, above: f64) -> f64 {
    let (slope, curvature) = (0.5 * (above - below), above - 2.0 * here + below);
    if curvature > 0.0 {
        (-slope / curvature).clamp(-REACH, REACH)
    } else if slope == 0.0 {
        0.0
    } else {
        -REACH * slope.signum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_s_vertex_is_found_within_reach() {
        let f = |x: f64| 3.0 + 2.0 * (x - 0.7).powi(2);
        assert!((parabola(f(-1.0), f(0.0), f(1.0)) - 0.7).abs() < 1e-12);
        let steep = |x: f64| (x + 9.0).powi(2);
        assert_eq!(parabola(steep(-1.0), steep(0.0), steep(1.0)), -REACH);
        assert_eq!(parabola(1.0, 2.0, 3.0), -REACH);
        assert_eq!(parabola(2.0, 2.0, 2.0), 0.0);
    }
}
