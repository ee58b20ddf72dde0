//! Particle swarm, from argmin: a search of the whole box at the fewest samples, then a simplex from its best particle.
//!
//! A swarm finds the right valley but creeps along its floor; the simplex, as free of derivatives, goes the rest.

use super::reported::Reported;
use super::stages::{self, iterations_left};
use super::trust_region::reach;
use super::{Outcome, nelder_mead};
use crate::objective::{Objective, Stopped};
use crate::{Normal, Options};
use argmin::core::{CostFunction, Executor, PopulationState};
use argmin::solver::particleswarm::{Particle, ParticleSwarm};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use std::cell::Cell;

const PARTICLES: usize = 40;
/// Iterations of the swarm, before the simplex.
const SWARM_ITERATIONS: u64 = 60;
/// Half the box, in each coordinate's reach: a roughness of 0.4 may become 0.07 to 0.87, an intensity 12 times itself.
const WINDOW: f64 = 2.5;

/// Swarm first, then simplexes at rising samples.
pub(super) fn solve(objective: &Objective<'_>, options: &Options) -> Result<Outcome, Stopped> {
    stages::run(objective, options, &mut |u, samples, normal, stage| {
        if stage > 0 {
            return nelder_mead::polish(objective, options, u, samples, normal, 0.05);
        }
        let best = swarm(objective, options, u, samples, normal)?;
        nelder_mead::polish(objective, options, &best, samples, &objective.normal(&best, samples)?, 0.2)
    })
}

fn swarm(
    objective: &Objective<'_>,
    options: &Options,
    u: &[f64],
    samples: u32,
    normal: &Normal,
) -> Result<Vec<f64>, Stopped> {
    objective.set_stage(samples, vec![1.0; u.len()]);
    let reach = reach(objective.space, normal);
    let bound = |sign: f64| u.iter().zip(&reach).map(|(u, r)| u + sign * WINDOW * r).collect::<Vec<f64>>();
    let solver = ParticleSwarm::new((bound(-1.0), bound(1.0)), PARTICLES)
        .with_rng_generator(Xoshiro256PlusPlus::seed_from_u64(options.seed));
    let cell = Cell::new(samples);
    let iterations = SWARM_ITERATIONS.min(iterations_left(objective, options));
    let done = Executor::new(objective, Reported { solver, samples: &cell })
        .configure(|state: PopulationState<Particle<Vec<f64>, f64>, f64>| state.max_iters(iterations))
        .ctrlc(false)
        .run()
        .map_err(|_| Stopped)?;
    // The swarm need not have been where it started from.
    let start = objective.cost(&u.to_vec()).map_err(|_| Stopped)?;
    let best = done.state.best_individual.filter(|p| p.cost < start);
    Ok(best.map_or_else(|| u.to_vec(), |p| p.position))
}
