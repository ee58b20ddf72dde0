//! Trust-region Gauss-Newton on debiased normal equations, as a solver of argmin.
//!
//! argmin's own Gauss-Newton needs the Jacobian and the residuals of every observation, and its trust-region method a
//! cost whose differences are exact. Here a photo is known by the sums J'WJ, J'Wr and its loss alone (no image crosses
//! the wire), and all three carry the render's noise. So this solver judges a step by the loss only as far as the
//! loss's standard error allows, and else by Newton's decrement, which the noise of the weights does not reach.

use super::schedule::Schedule;
use crate::normal::{Normal, Spectrum};
use crate::objective::{Objective, Stopped};
use crate::uncertainty::Uncertainty;
use crate::{Space, Transform};
use argmin::core::{Error, IterState, KV, Problem, Solver, TerminationReason, TerminationStatus};
use nalgebra::DVector;
use std::cell::Cell;

/// The state that argmin keeps for a solver without matrices of its own.
pub(super) type PointState = IterState<Vec<f64>, (), (), (), (), f64>;

/// When a run of the solver ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Goal {
    /// At the first samples, once the step left is a few standard errors.
    Descend,
    /// At the samples that make the render's noise negligible, once one more step leaves less than the tolerance.
    Polish,
}

/// Step bounds: a relative move of a positive parameter, logits of a bounded one.
const FIRST_RADIUS: f64 = 1.0;
const LARGEST_RADIUS: f64 = 4.0;
const SMALLEST_RADIUS: f64 = 1e-3;
/// Longest part of the step left, in reported standard errors, from which on the model is as good as linear.
const NEAR: f64 = 3.0;
/// Undamped step, as a part of each coordinate's reach, from which on it is so too, however small the errors are.
const SHORT: f64 = 0.1;
/// A parameter without natural scale moves, within a radius of one, no further than changes the observations by this
/// many standard deviations in the root mean square.
const VISIBLE: f64 = 10.0;

/// The solver.
pub(super) struct TrustRegion<'c> {
    pub goal: Goal,
    pub schedule: Schedule,
    /// Step left, in standard errors, after the last one, which the caller takes without another evaluation.
    pub tolerance: f64,
    /// Samples per pixel of the current point.
    pub samples: &'c Cell<u32>,
    radius: f64,
    here: Option<Here>,
    /// Samples and step left at the last point that a step was taken from.
    before: Option<(u32, f64)>,
    verdict: Option<bool>,
}

/// The current point.
struct Here {
    u: Vec<f64>,
    normal: Normal,
    spectrum: Spectrum,
    uncertainty: Uncertainty,
    reach: Vec<f64>,
}

impl Here {
    fn at(objective: &Objective<'_>, u: Vec<f64>, samples: u32) -> Result<Self, Stopped> {
        let normal = objective.movable(&u, samples)?;
        let (spectrum, reach) = (normal.spectrum(), reach(objective.space, &normal));
        let uncertainty = objective.uncertainty(&u, samples)?;
        Ok(Self { u, normal, spectrum, uncertainty, reach })
    }

    /// The longest part of the step left, in the standard errors that are reported.
    fn left(&self) -> f64 {
        self.uncertainty.longest(self.spectrum.step(0.0).as_slice())
    }

    /// Whether the undamped step is short.
    fn is_short(&self) -> bool {
        self.spectrum.step(0.0).iter().zip(&self.reach).all(|(s, r)| s.abs() <= SHORT * r)
    }

    /// Whether the undamped step needs no test.
    fn is_near(&self) -> bool {
        self.left() <= NEAR || self.is_short()
    }

    fn cost(&self) -> f64 {
        0.5 * (self.normal.total.loss() - self.normal.total.noise_floor)
    }
}

impl<'c> TrustRegion<'c> {
    pub fn new(goal: Goal, schedule: Schedule, tolerance: f64, samples: &'c Cell<u32>) -> Self {
        Self { goal, schedule, tolerance, samples, radius: FIRST_RADIUS, here: None, before: None, verdict: None }
    }

    /// Whether the run has ended because the step left is small enough.
    pub fn converged(&self) -> bool {
        self.verdict == Some(true)
    }

    /// Ends the run if the goal is met or cannot be.
    fn judge(&mut self, here: &Here) {
        let more = self.schedule.next(self.samples.get(), &here.uncertainty).is_some();
        let left = here.left();
        // Steps shrink by a factor that the last two of one sample count show: what the next leaves is known before it is taken.
        let shrinks = match self.before {
            Some((samples, before)) if samples == self.samples.get() && before > 0.0 => (left / before).min(1.0),
            _ => 1.0,
        };
        match self.goal {
            Goal::Descend if here.is_near() => self.verdict = Some(true),
            Goal::Polish if more => {}
            Goal::Polish if here.is_near() && left * shrinks <= self.tolerance => self.verdict = Some(true),
            _ if self.radius < SMALLEST_RADIUS => self.verdict = Some(false),
            _ => {}
        }
    }

    /// One step from `here`: the point to go on from.
    fn advance(&mut self, objective: &Objective<'_>, here: Here) -> Result<Here, Stopped> {
        let samples = self.samples.get();
        if self.radius < SMALLEST_RADIUS
            && let Some(more) = self.schedule.next(samples, &here.uncertainty)
        {
            // Stuck in this sample count's noise; the next has less.
            self.samples.set(more);
            self.radius = FIRST_RADIUS;
            return Here::at(objective, here.u, more);
        }
        self.before = Some((samples, here.left()));
        let step = bounded_step(&here.spectrum, &here.reach, self.radius);
        let u = objective.space.retract(&here.u, step.as_slice());
        // A step of a few standard errors needs no test: it is taken on the way to the next samples, so that no
        // evaluation is spent on converging to what this sample count's noise has made of the minimum.
        if self.goal == Goal::Polish
            && here.is_near()
            && let Some(more) = self.schedule.next(samples, &here.uncertainty)
        {
            self.samples.set(more);
            return Here::at(objective, u, more);
        }
        let there = Here::at(objective, u, samples)?;
        let promised = -(2.0 * here.normal.gradient.dot(&step) + step.dot(&(&here.normal.matrix * &step)));
        let decrease = here.normal.total.loss() - there.normal.total.loss();
        let noise = 2.0 * (here.normal.total.loss_variance() + there.normal.total.loss_variance()).max(0.0).sqrt();
        let calmer = there.spectrum.decrement() < here.spectrum.decrement();
        let accepted = decrease > 0.01 * promised.abs() || (decrease > -noise && calmer);
        let size = step.iter().zip(&here.reach).map(|(s, r)| s.abs() / r).fold(0.0, f64::max);
        if !accepted {
            self.radius = 0.3 * self.radius.min(size);
        } else if promised > noise && decrease < 0.25 * promised {
            self.radius *= 0.5;
        } else if size > 0.7 * self.radius && decrease > 0.75 * promised {
            self.radius = (2.0 * self.radius).min(LARGEST_RADIUS);
        }
        Ok(if accepted { there } else { here })
    }
}

/// The largest sensible move of each coordinate at once.
pub(super) fn reach(space: &Space, normal: &Normal) -> Vec<f64> {
    let curvature = normal.matrix.diagonal();
    let natural = |(i, t): (usize, &Transform)| match t {
        Transform::Identity if curvature[i] > 0.0 => VISIBLE * (normal.observations() / curvature[i]).sqrt(),
        _ => 1.0,
    };
    space.transforms().iter().enumerate().map(natural).collect()
}

/// The least damped step that moves no coordinate further than `radius` times its reach.
fn bounded_step(spectrum: &Spectrum, reach: &[f64], radius: f64) -> DVector<f64> {
    let fits = |step: &DVector<f64>| step.iter().zip(reach).all(|(s, r)| s.abs() <= radius * r);
    let mut step = spectrum.step(0.0);
    let mut damping = 1e-6;
    // Up to 1e12, where any step has vanished; beyond, numbers are not finite and the step is refused.
    while !fits(&step) && damping < 1e12 {
        step = spectrum.step(damping);
        damping *= 1.5;
    }
    step
}

impl<'o, 'a> Solver<&'o Objective<'a>, PointState> for TrustRegion<'_> {
    fn name(&self) -> &str {
        "trust-region Gauss-Newton"
    }

    fn init(
        &mut self,
        problem: &mut Problem<&'o Objective<'a>>,
        state: PointState,
    ) -> Result<(PointState, Option<KV>), Error> {
        let (Some(objective), Some(u)) = (problem.problem, state.param.clone()) else { return Err(Stopped.into()) };
        let here = Here::at(objective, u, self.samples.get())?;
        self.judge(&here);
        let cost = here.cost();
        self.here = Some(here);
        Ok((state.cost(cost), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<&'o Objective<'a>>,
        state: PointState,
    ) -> Result<(PointState, Option<KV>), Error> {
        let (Some(objective), Some(here)) = (problem.problem, self.here.take()) else { return Err(Stopped.into()) };
        let next = self.advance(objective, here)?;
        self.judge(&next);
        let (u, cost) = (next.u.clone(), next.cost());
        self.here = Some(next);
        Ok((state.param(u).cost(cost), None))
    }

    fn terminate(&mut self, _: &PointState) -> TerminationStatus {
        match self.verdict {
            Some(true) => TerminationStatus::Terminated(TerminationReason::SolverConverged),
            Some(false) => {
                TerminationStatus::Terminated(TerminationReason::SolverExit("no step lowers the loss".to_owned()))
            }
            None => TerminationStatus::NotTerminated,
        }
    }
}
