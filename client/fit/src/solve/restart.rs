//! Another start, where the first descent ended in a false minimum.
//!
//! The loss over roughness has false minima: a highlight of the wrong width is best removed, by an index of refraction
//! near 1 or by any width that hides it. A few widths, each judged after one linear step of everything else, find the
//! right valley at a handful of evaluations with the fewest samples.

use super::Outcome;
use crate::objective::{Objective, Stopped};

/// Perceptual roughnesses tried.
const GRID: [f64; 4] = [0.15, 0.3, 0.5, 0.75];
/// The index of most plastics, glasses and lacquers; one near 1 has no highlight that could be mended.
const USUAL_IOR: f64 = 1.5;
/// Reduced chi-square that a right model stays below, whatever the samples.
const GOOD: f64 = 1.2;

/// The better of `first` and what `descend` reaches from another roughness, where `first` does not explain the photos;
/// `scaled` are the coordinates that it started from.
pub(super) fn improve(
    objective: &Objective<'_>,
    scaled: &[f64],
    first: Outcome,
    descend: &mut dyn FnMut(Vec<f64>) -> Result<Outcome, Stopped>,
) -> Result<Outcome, Stopped> {
    let space = objective.space;
    let rough = space.of_key("roughness");
    let reached = objective.normal(&first.position, first.samples)?;
    if rough.is_empty() || reached.total.reduced_chi_square() <= GOOD {
        return Ok(first);
    }
    let others: Vec<bool> = (0..space.len()).map(|i| !rough.contains(&i)).collect();
    let mut best: Option<(f64, Vec<f64>)> = None;
    for roughness in GRID {
        let mut u = scaled.to_vec();
        for (key, value) in [("roughness", roughness), ("ior", USUAL_IOR)] {
            for i in space.of_key(key) {
                u[i] = space.transforms()[i].coordinate(value);
            }
        }
        let normal = objective.normal(&u, first.samples)?;
        let promise = normal.total.loss() - normal.restricted(&others).spectrum().decrement();
        if best.as_ref().is_none_or(|(b, _)| promise < *b) {
            best = Some((promise, u));
        }
    }
    let Some((_, start)) = best else { return Ok(first) };
    let second = descend(start)?;
    let lower = objective.normal(&second.position, second.samples)?.total.loss() < reached.total.loss();
    let better = if lower { second } else { first };
    objective.place(&better.position, better.samples);
    Ok(better)
}
