//! Nelder and Mead's simplex, from argmin, restarted until a fresh simplex finds nothing better.

use super::reported::Reported;
use super::stages::iterations_left;
use super::trust_region::{PointState, reach};
use super::{Outcome, stages::run as run_stages};
use crate::objective::{Objective, Stopped};
use crate::{Normal, Options};
use argmin::core::{CostFunction, Executor};
use argmin::solver::neldermead::NelderMead;
use std::cell::Cell;

/// Edge of the first simplex, as a part of each coordinate's reach; later stages start nearer to the minimum.
const EDGE: f64 = 0.5;

/// Runs simplex after simplex at rising samples.
pub(super) fn solve(objective: &Objective<'_>, options: &Options) -> Result<Outcome, Stopped> {
    run_stages(objective, options, &mut |u, samples, normal, stage| {
        let edge = if stage == 0 { EDGE } else { 0.1 * EDGE };
        polish(objective, options, u, samples, normal, edge)
    })
}

/// Simplexes from `u`, each from where the last collapsed, until one gains less than matters.
pub(super) fn polish(
    objective: &Objective<'_>,
    options: &Options,
    u: &[f64],
    samples: u32,
    normal: &Normal,
    edge: f64,
) -> Result<Vec<f64>, Stopped> {
    objective.set_stage(samples, vec![1.0; u.len()]);
    let reach = reach(objective.space, normal);
    let cost = |u: &Vec<f64>| objective.cost(u).map_err(|_| Stopped);
    let (mut u, mut edge) = (u.to_vec(), edge);
    let mut lowest = cost(&u)?;
    while iterations_left(objective, options) > 0 {
        let next = simplex(objective, options, &u, samples, &reach, edge, 0.02 * normal.misfit())?;
        let reached = cost(&next)?;
        let gain = lowest - reached;
        if gain > 0.0 {
            (u, lowest) = (next, reached);
        }
        // A cost of 0.5 is one standard error.
        if gain < 0.05 * normal.misfit() {
            break;
        }
        // Alternate signs explore the other side of a narrow valley.
        edge *= -0.5;
    }
    Ok(u)
}

fn simplex(
    objective: &Objective<'_>,
    options: &Options,
    u: &[f64],
    samples: u32,
    reach: &[f64],
    edge: f64,
    spread: f64,
) -> Result<Vec<f64>, Stopped> {
    let mut vertices = vec![u.to_vec()];
    for (i, r) in reach.iter().enumerate() {
        let mut vertex = u.to_vec();
        vertex[i] += edge * r;
        // argmin's first evaluations panic where they fail; evaluated here first, they are remembered and cannot.
        objective.cost(&vertex).map_err(|_| Stopped)?;
        vertices.push(vertex);
    }
    objective.cost(&u.to_vec()).map_err(|_| Stopped)?;
    let solver = NelderMead::new(vertices).with_sd_tolerance(spread).map_err(|_| Stopped)?;
    let samples = Cell::new(samples);
    let done = Executor::new(objective, Reported { solver, samples: &samples })
        .configure(|state: PointState| state.max_iters(iterations_left(objective, options)))
        .ctrlc(false)
        .run()
        .map_err(|_| Stopped)?;
    Ok(done.state.best_param.unwrap_or_else(|| u.to_vec()))
}
