//! The default: scale, descend at few samples, start again where that ended badly, polish at as many as it takes.

use super::reported::Reported;
use super::trust_region::{Goal, PointState, TrustRegion};
use super::{Outcome, Schedule, restart, scale};
use crate::Options;
use crate::objective::{Objective, Stopped};
use argmin::core::Executor;
use std::cell::Cell;

/// Runs the whole strategy.
pub(super) fn solve(objective: &Objective<'_>, options: &Options) -> Result<Outcome, Stopped> {
    let scaled = scale::solve(objective, options.min_samples)?;
    let first = run(objective, options, scaled.clone(), Goal::Descend)?;
    let best = restart::improve(objective, &scaled, first, &mut |u| run(objective, options, u, Goal::Descend))?;
    let last = run(objective, options, best.position, Goal::Polish)?;
    if !last.converged {
        return Ok(last);
    }
    // The step that is left is worth taking, but not another evaluation at the most samples to look back on it.
    let step = objective.movable(&last.evaluated, last.samples)?.spectrum().step(0.0);
    Ok(Outcome { position: objective.space.retract(&last.evaluated, step.as_slice()), ..last })
}

/// One run of the trust region from coordinates `start` at the first samples.
pub(super) fn run(
    objective: &Objective<'_>,
    options: &Options,
    start: Vec<f64>,
    goal: Goal,
) -> Result<Outcome, Stopped> {
    let samples = Cell::new(options.min_samples);
    objective.set_stage(options.min_samples, vec![1.0; start.len()]);
    let schedule = Schedule { max: options.max_samples };
    let solver = TrustRegion::new(goal, schedule, options.tolerance, &samples);
    let left = options.iterations().saturating_sub(objective.iteration_count());
    let done = Executor::new(objective, Reported { solver, samples: &samples })
        .configure(|state: PointState| state.param(start.clone()).max_iters(u64::from(left)))
        .ctrlc(false)
        .run()
        .map_err(|_| Stopped)?;
    let position = done.state.param.clone().unwrap_or(start);
    objective.place(&position, samples.get());
    Ok(Outcome {
        evaluated: position.clone(),
        position,
        samples: samples.get(),
        converged: done.solver.solver.converged(),
    })
}
