//! What the general-purpose solvers share: the same search at more and more samples, and one judgement at the end.

use super::{Outcome, Schedule, restart, scale};
use crate::Options;
use crate::normal::Normal;
use crate::objective::{Objective, Stopped};

/// Step left, in standard errors, with which a search without curvature may end.
const TOLERANCE: f64 = 0.5;

/// One stage's work: from coordinates, at samples per pixel, with the normal equations there; returns coordinates.
pub(super) type Search<'s> = dyn FnMut(&[f64], u32, &Normal, usize) -> Result<Vec<f64>, Stopped> + 's;

/// Runs `search` from the scaled start, then again from where it ended at the next samples, until these are enough.
pub(super) fn run(objective: &Objective<'_>, options: &Options, search: &mut Search<'_>) -> Result<Outcome, Stopped> {
    let schedule = Schedule { max: options.max_samples };
    let mut samples = options.min_samples;
    let scaled = scale::solve(objective, samples)?;
    let mut descend = |u: Vec<f64>| {
        let position = search(&u, samples, &objective.normal(&u, samples)?, 0)?;
        Ok(Outcome { evaluated: position.clone(), position, samples, converged: false })
    };
    let first = descend(scaled.clone())?;
    let mut u = restart::improve(objective, &scaled, first, &mut descend)?.position;
    for stage in 0.. {
        if stage > 0 {
            u = search(&u, samples, &objective.normal(&u, samples)?, stage)?;
        }
        let after = objective.movable(&u, samples)?;
        objective.place(&u, samples);
        let out_of_iterations = objective.iteration_count() >= options.iterations();
        let uncertainty = objective.uncertainty(&u, samples)?;
        match schedule.next(samples, &uncertainty) {
            Some(more) if !out_of_iterations => samples = more,
            _ => {
                let left = uncertainty.longest(after.spectrum().step(0.0).as_slice());
                let tolerance = options.tolerance.max(TOLERANCE);
                return Ok(Outcome { evaluated: u.clone(), position: u, samples, converged: left <= tolerance });
            }
        }
    }
    Err(Stopped)
}

/// Iterations that are left of the options' budget.
pub(super) fn iterations_left(objective: &Objective<'_>, options: &Options) -> u64 {
    u64::from(options.iterations().saturating_sub(objective.iteration_count()))
}
