//! A solver that tells the objective of each of its iterations.

use crate::objective::Objective;
use argmin::core::{Error, KV, Problem, Solver, State, TerminationStatus};
use argmin::solver::particleswarm::Particle;
use std::cell::Cell;

/// What a solver calls its parameter, as a point.
pub(super) trait Point {
    /// The point's numbers.
    fn numbers(&self) -> &[f64];
}

impl Point for Vec<f64> {
    fn numbers(&self) -> &[f64] {
        self
    }
}

impl Point for Particle<Vec<f64>, f64> {
    fn numbers(&self) -> &[f64] {
        &self.position
    }
}

/// Wraps a solver of argmin. argmin's own observers must live for ever, so they could not borrow the caller's, and they
/// cannot end a run.
pub(super) struct Reported<'c, S> {
    pub solver: S,
    /// Samples per pixel of the current point; a solver that raises them itself shares the cell.
    pub samples: &'c Cell<u32>,
}

impl<'o, 'a, S, I> Solver<&'o Objective<'a>, I> for Reported<'_, S>
where
    S: Solver<&'o Objective<'a>, I>,
    I: State<Float = f64>,
    I::Param: Point,
{
    fn name(&self) -> &str {
        self.solver.name()
    }

    fn init(&mut self, problem: &mut Problem<&'o Objective<'a>>, state: I) -> Result<(I, Option<KV>), Error> {
        self.solver.init(problem, state)
    }

    fn next_iter(&mut self, problem: &mut Problem<&'o Objective<'a>>, state: I) -> Result<(I, Option<KV>), Error> {
        let (state, notes) = self.solver.next_iter(problem, state)?;
        if let (Some(objective), Some(point)) = (problem.problem, state.get_param()) {
            objective.iteration_done(&objective.coordinates(point.numbers()), self.samples.get())?;
        }
        Ok((state, notes))
    }

    fn terminate(&mut self, state: &I) -> TerminationStatus {
        self.solver.terminate(state)
    }
}
