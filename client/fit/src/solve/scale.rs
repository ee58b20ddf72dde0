//! The first step of every solver: light intensities and gains, in which photo values are linear.
//!
//! A capture's first guess of an intensity may be off by any factor. One step of the normal equations that holds all
//! other parameters finds it exactly (variable projection; Golub and Pereyra 1973), and only then do the other
//! parameters' residuals say anything about them.

use crate::Normal;
use crate::objective::{Objective, Stopped};

/// An intensity may grow by this factor at once, or shrink to its inverse.
const LARGEST_FACTOR: f64 = 1e4;

/// Starting coordinates with the linear parameters solved for, if that lowers the loss.
pub(super) fn solve(objective: &Objective<'_>, samples: u32) -> Result<Vec<f64>, Stopped> {
    let space = objective.space;
    let start = space.start_coordinates();
    let photos = objective.statistics(&start, samples, true)?;
    objective.place(&start, samples);
    let linear = space.linear();
    if !linear.contains(&true) {
        return Ok(start);
    }
    let physical = Normal::new(&photos, &vec![1.0; space.len()]);
    let step = physical.restricted(&linear).spectrum().step(0.0);
    let mut scaled = start.clone();
    for (i, value) in space.values(&start).iter().enumerate().filter(|(i, _)| linear.get(*i) == Some(&true)) {
        let target = value + step[i];
        // A negative intensity says that other parameters are far off, not how dark the light is.
        let target =
            if target > 0.0 { target.clamp(value / LARGEST_FACTOR, value * LARGEST_FACTOR) } else { 0.1 * value };
        scaled[i] = space.transforms()[i].coordinate(target);
    }
    if scaled == start {
        return Ok(start);
    }
    let lower = objective.normal(&scaled, samples)?.total.loss() < physical.total.loss();
    let best = if lower { scaled } else { start };
    objective.iteration_done(&best, samples)?;
    Ok(best)
}
