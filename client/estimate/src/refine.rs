//! Render and compare: poses near a candidate, until none is better.

use crate::candidate::Candidate;
use crate::likelihood::Likelihood;
use argmin::core::{CostFunction, Executor, IterState};
use argmin::solver::neldermead::NelderMead;
use glam::{DMat3, DVec3};
use gonio_pose::Pose;

/// First steps: across the view as a part of the diameter, along it as a part of the distance, turns in radians.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Steps {
    pub across: f64,
    pub along: f64,
    pub turn: f64,
}

impl Steps {
    /// Half of what lies between neighbouring templates.
    pub const COARSE: Self = Self { across: 0.05, along: 0.06, turn: 0.14 };
    /// What a round from there leaves open.
    pub const MIDDLE: Self = Self { across: 0.025, along: 0.03, turn: 0.09 };
    /// What a picture of some fifty pixels leaves open.
    pub const FINE: Self = Self { across: 0.012, along: 0.015, turn: 0.05 };
}

struct Cost<'a> {
    likelihood: &'a Likelihood<'a>,
    from: Pose,
    centre: DVec3,
    diameter: f64,
    steps: Steps,
}

impl Cost<'_> {
    /// The pose at coordinates in units of the steps.
    fn pose(&self, u: &[f64]) -> Pose {
        let at = |i: usize| u.get(i).copied().unwrap_or(0.0);
        let turn = DVec3::new(at(3), at(4), at(5)) * self.steps.turn;
        let rotation = turn.try_normalize().map_or(DMat3::IDENTITY, |axis| DMat3::from_axis_angle(axis, turn.length()));
        let centre = self.from.apply(self.centre);
        // Along the ray, so that its place in the image stays.
        let moved = (centre + DVec3::new(at(0), at(1), 0.0) * self.steps.across * self.diameter)
            * libm::exp(self.steps.along * at(2));
        let rotation = rotation * self.from.rotation;
        Pose { rotation, translation: moved - rotation * self.centre }
    }
}

impl CostFunction for &Cost<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, u: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        let cost = -self.likelihood.of(&self.pose(u));
        // Out of sight is worse than anything seen; a simplex cannot compare infinities.
        Ok(if cost.is_finite() { cost } else { f64::MAX / 1e10 })
    }
}

/// A further simplex is worth its time where the last one gained this part of the likelihood.
const GAIN: f64 = 0.01;

/// How long to look.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Simplexes one after the other, each from where the last ended, at most.
    pub simplexes: u32,
    /// Iterations of each.
    pub iterations: u64,
}

/// The best pose that Nelder and Mead's simplexes find from `start`, and its likelihood. `centre` is the
/// part's, in model coordinates.
pub(crate) fn refine(
    likelihood: &Likelihood<'_>,
    start: &Pose,
    centre: DVec3,
    diameter: f64,
    steps: Steps,
    effort: Effort,
) -> Candidate {
    let mut best = Candidate { pose: *start, score: likelihood.of(start) };
    let mut edge = 1.0;
    for _ in 0..effort.simplexes {
        let cost = Cost { likelihood, from: best.pose, centre, diameter, steps };
        let before = best.score;
        if let Some(better) = simplex(&cost, edge, effort.iterations).filter(|better| better.score > before) {
            best = better;
        }
        if best.score.is_nan() || best.score - before < GAIN * before.abs() {
            break;
        }
        // The other side of a narrow valley.
        edge *= -0.7;
    }
    best
}

/// Where a simplex with edges of so many steps ends.
fn simplex(cost: &Cost<'_>, edge: f64, iterations: u64) -> Option<Candidate> {
    let mut vertices = vec![vec![0.0; 6]];
    for i in 0..6 {
        let mut vertex = vec![0.0; 6];
        vertex[i] = edge;
        vertices.push(vertex);
    }
    let solver = NelderMead::new(vertices).with_sd_tolerance(1e-6).ok()?;
    let run = Executor::new(cost, solver)
        .configure(|state: IterState<Vec<f64>, (), (), (), (), f64>| state.max_iters(iterations))
        .ctrlc(false)
        .run()
        .ok()?;
    let score = -run.state.best_cost;
    run.state.best_param.map(|u| Candidate { pose: cost.pose(&u), score })
}
