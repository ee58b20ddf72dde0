//! The solvers. All run through argmin's executor on one [`Objective`](crate::objective::Objective), so that events,
//! checkpoints, bounds, cancellation and the raising of samples are the same for each.

mod gauss_newton;
mod l_bfgs;
mod nelder_mead;
mod particle_swarm;
mod reported;
mod restart;
mod scale;
mod schedule;
mod stages;
mod trust_region;

pub(crate) use schedule::Schedule;

use crate::objective::{Objective, Stopped};
use crate::{Options, SolverName};

/// Where a solver has arrived.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    /// Coordinates of the estimate.
    pub position: Vec<f64>,
    /// Coordinates of the last evaluation: the estimate, or less than a standard error beside it.
    pub evaluated: Vec<f64>,
    /// Samples per pixel of that evaluation.
    pub samples: u32,
    /// Whether the step left is below the tolerance.
    pub converged: bool,
}

/// Runs the solver that the options name.
pub(crate) fn solve(objective: &Objective<'_>, options: &Options) -> Result<Outcome, Stopped> {
    match options.solver {
        SolverName::GaussNewton => gauss_newton::solve(objective, options),
        SolverName::NelderMead => nelder_mead::solve(objective, options),
        SolverName::LBfgs => l_bfgs::solve(objective, options),
        SolverName::ParticleSwarm => particle_swarm::solve(objective, options),
    }
}
