//! Limited-memory BFGS, from argmin, in coordinates that the first normal equations have scaled.

use super::Outcome;
use super::reported::Reported;
use super::stages::{self, iterations_left};
use crate::Options;
use crate::objective::{Objective, Stopped};
use argmin::core::{Executor, IterState};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use std::cell::Cell;

/// Pairs of steps and gradient changes remembered: more than a fit has parameters that are hard to tell apart.
const MEMORY: usize = 12;
/// Line searches that may fail in a row before a stage ends.
const PATIENCE: u32 = 3;

type GradientState = IterState<Vec<f64>, Vec<f64>, (), (), (), f64>;

/// Runs a search at each sample count.
pub(super) fn solve(objective: &Objective<'_>, options: &Options) -> Result<Outcome, Stopped> {
    stages::run(objective, options, &mut |u, samples, _, _| {
        let mut u = u.to_vec();
        for _ in 0..PATIENCE {
            // The metric is of the current point: one of a far start would make the valley narrower than it is.
            let normal = objective.normal(&u, samples)?;
            let scale = normal.spectrum().inverse_scale;
            objective.set_stage(samples, scale.iter().map(|s| if *s > 0.0 { *s } else { 1.0 }).collect());
            let before = normal.total.loss();
            u = search(objective, options, &u, samples, normal.misfit())?;
            let gain = before - objective.normal(&u, samples)?.total.loss();
            if gain < 0.1 * normal.misfit() || iterations_left(objective, options) == 0 {
                break;
            }
        }
        Ok(u)
    })
}

fn search(
    objective: &Objective<'_>,
    options: &Options,
    u: &[f64],
    samples: u32,
    misfit: f64,
) -> Result<Vec<f64>, Stopped> {
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY)
        .with_tolerance_grad(0.1 * options.tolerance * misfit.sqrt())
        .and_then(|s| s.with_tolerance_cost(1e-4))
        .map_err(|_| Stopped)?;
    let cell = Cell::new(samples);
    let start = objective.parameters(u);
    let done = Executor::new(objective, Reported { solver, samples: &cell })
        .configure(|state: GradientState| state.param(start).max_iters(iterations_left(objective, options)))
        .ctrlc(false)
        .run()
        .map_err(|_| Stopped)?;
    // A line search that has failed leaves no current point, but the best one.
    let best = done.state.best_param.or(done.state.param);
    Ok(best.map_or_else(|| u.to_vec(), |p| objective.coordinates(&p)))
}
