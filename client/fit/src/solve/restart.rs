//! Other starts, where the first descent ended in a false minimum.
//!
//! The loss over roughness has false minima: a highlight of the wrong width is best removed, by an index of refraction
//! near 1 or by any width that hides it. A few widths, each judged after one linear step of everything else, find the
//! right valley at a handful of evaluations with the fewest samples.

use super::Outcome;
use super::gauss_newton::run;
use super::trust_region::Goal;
use crate::Options;
use crate::objective::{Objective, Stopped};

/// Perceptual roughnesses tried.
const GRID: [f64; 4] = [0.15, 0.3, 0.5, 0.75];
/// Reduced chi-square that a right model stays below even at the fewest samples.
const GOOD: f64 = 1.2;

/// The better of `first` and the best descent from another roughness; `scaled` are the starting coordinates.
pub(super) fn improve(
    objective: &Objective<'_>,
    options: &Options,
    scaled: &[f64],
    first: Outcome,
) -> Result<Outcome, Stopped> {
    let space = objective.space;
    let rough = space.roughnesses();
    let samples = options.min_samples;
    let reached = objective.normal(&first.position, samples)?;
    if rough.is_empty() || reached.misfit() <= GOOD || objective.iteration_count() >= options.iterations() {
        return Ok(first);
    }
    let others: Vec<bool> = (0..space.len()).map(|i| !rough.contains(&i)).collect();
    let mut best: Option<(f64, Vec<f64>)> = None;
    for roughness in GRID {
        let mut u = scaled.to_vec();
        for i in &rough {
            u[*i] = space.transforms()[*i].coordinate(roughness);
        }
        let normal = objective.normal(&u, samples)?;
        let promise = normal.total.chi_square - normal.restricted(&others).spectrum().decrement();
        if best.as_ref().is_none_or(|(b, _)| promise < *b) {
            best = Some((promise, u));
        }
    }
    let Some((_, start)) = best else { return Ok(first) };
    let second = run(objective, options, start, Goal::Descend)?;
    let lower = objective.normal(&second.position, samples)?.total.chi_square < reached.total.chi_square;
    let better = if lower { second } else { first };
    objective.place(&better.position, better.samples);
    Ok(better)
}
