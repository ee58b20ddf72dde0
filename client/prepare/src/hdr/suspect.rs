//! Exposure times that the photos contradict.

use super::patches::{Patch, patches};
use super::region::Region;
use super::response::Response;
use super::solve::{at, hat, log_radiance, solve};
use super::stack::Stack;

/// Smallest error that is named, in stops.
const SMALLEST_STOPS: f64 = 0.2;
/// What is left of the disagreement without the shot, for the shot to be at fault.
const LARGEST_REST: f64 = 0.5;

/// A shot whose time is not what the other shots say.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// The shot's name.
    pub name: String,
    /// Time that was given, seconds.
    pub given: f64,
    /// Time that agrees with the others, seconds.
    pub found: f64,
}

/// Finds shots whose time contradicts the others, and sets their times to what the others say. Each shot in turn is left
/// out: without a wrong one the rest agrees, under its own curve (or `known`, if the response is), and that curve tells the
/// left-out shot's time. At most a third of the shots is corrected; of fewer than four shots nobody can say which errs, so
/// none is.
pub fn correct_times(stack: &mut Stack, region: Region, known: Option<&Response>) -> Vec<Suspect> {
    let mut suspects: Vec<Suspect> = Vec::new();
    // At a curve's steep ends residuals are large for other reasons, such as a film's fog.
    let mut patches = patches(stack, region, 1);
    for value in patches.iter_mut().flatten() {
        *value = value.filter(|value| (0.1..0.94).contains(value));
    }
    patches.retain(|patch| patch.iter().flatten().count() >= 2);
    if stack.shots().len() < 4 || patches.len() < 20 {
        return suspects;
    }
    let curve = |times: &[Option<f64>]| known.map_or_else(|| solve(&patches, times), |r| r.log_exposure[1].clone());
    for _ in 0..stack.shots().len() / 3 {
        let times: Vec<Option<f64>> = stack.log_times().into_iter().map(Some).collect();
        let all = disagreement(&curve(&times), &patches, &times);
        let mut best: Option<(f64, usize, f64)> = None;
        for shot in 0..times.len() {
            let mut without = times.clone();
            without[shot] = None;
            let g = curve(&without);
            let Some(offset) = offset(&g, &patches, &without, shot) else { continue };
            let rest = disagreement(&g, &patches, &without);
            if best.is_none_or(|(least, _, _)| rest < least) {
                best = Some((rest, shot, offset - times[shot].unwrap_or(0.0)));
            }
        }
        let Some((rest, shot, error)) = best else { break };
        if rest > LARGEST_REST * all || error.abs() < SMALLEST_STOPS * std::f64::consts::LN_2 {
            break;
        }
        let given = stack.shots()[shot].seconds;
        let found = given * libm::exp(error);
        let name = stack.shots()[shot].name.clone();
        stack.set_seconds(shot, found);
        match suspects.iter_mut().find(|suspect| suspect.name == name) {
            Some(suspect) => suspect.found = found,
            None => suspects.push(Suspect { name, given, found }),
        }
    }
    suspects
}

/// Weighted mean of |g(z) - ln E - ln t| over the patches.
fn disagreement(g: &[f64], patches: &[Patch], times: &[Option<f64>]) -> f64 {
    let (mut sum, mut total) = (0.0, 1e-9);
    for patch in patches {
        let Some(radiance) = log_radiance(g, patch, times) else { continue };
        for (value, time) in patch.iter().zip(times) {
            if let (&Some(value), &Some(time)) = (value, time) {
                sum += hat(value) * (at(g, value) - radiance - time).abs();
                total += hat(value);
            }
        }
    }
    sum / total
}

/// ln t of a left-out shot: the median over patches that the others expose, too.
fn offset(g: &[f64], patches: &[Patch], without: &[Option<f64>], shot: usize) -> Option<f64> {
    let mut found: Vec<f64> = patches
        .iter()
        .filter_map(|patch| {
            let value = patch[shot].filter(|value| (0.1..0.9).contains(value))?;
            Some(at(g, value) - log_radiance(g, patch, without)?)
        })
        .collect();
    if found.len() < 10 {
        return None;
    }
    found.sort_by(f64::total_cmp);
    Some(found[found.len() / 2])
}
