//! Corners that contradict the others: a robust start, the noise of the others, and who is farther off than it allows.

use super::bundle::{OWN, State, Weights};
use super::model::Model;
use crate::board::Corner;
use crate::homography::homography;

/// Fewer corners than this leave a pose open.
pub(crate) const FEWEST: usize = 6;
/// A corner that is farther off than so many standard deviations is dropped: of Gaussian ones, one in 270,000 is.
const FARTHEST: f64 = 5.0;
/// The noise of a photo, in units of that of all: a blurred photo's corners are all a little worse, and none is wrong.
const BLURRED: f64 = 3.0;
/// No finder of corners is better than this, pixels.
const FINEST: f64 = 1e-3;
/// The median distance of two Gaussian residuals of standard deviation 1: sqrt(2 ln 2).
const MEDIAN: f64 = 1.177_410;
/// Where the Cauchy weight of a corner is a half, in standard deviations: 0.95 of the efficiency (Holland and Welsch 1977).
const CAUCHY: f64 = 2.385;
/// Rounds after which weights no longer change what is dropped.
const ROUNDS: usize = 10;

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// The standard deviation of a corner along one axis, pixels, by the median distance of those in photos that count.
pub(crate) fn noise(state: &State, model: Model, photos: &[Vec<Corner>], weights: &Weights) -> f64 {
    let distances = state.distances(photos);
    let counts = |weights: &&Vec<f64>| weights.iter().any(|weight| *weight > 0.0);
    let used: Vec<f64> = distances
        .into_iter()
        .zip(weights)
        .filter(|(_, weights)| counts(weights))
        .flat_map(|(distances, _)| distances)
        .collect();
    let numbers = 2.0 * used.len() as f64;
    let unknowns = (OWN * weights.iter().filter(counts).count() + model.columns()) as f64;
    // What was fitted took its part of the residuals away.
    let share = (1.0 - unknowns / numbers).max(0.1);
    (median(used) / MEDIAN / share.sqrt()).max(FINEST)
}

/// The standard deviation of one photo's corners, pixels, by their median distance.
pub(crate) fn photo_noise(distances: &[f64]) -> f64 {
    median(distances.to_vec()) / MEDIAN
}

/// Solves with weights that fall where corners are far off, from `state` and the weights that it came from.
pub(crate) fn soften(
    mut state: State,
    model: Model,
    photos: &[Vec<Corner>],
    mut weights: Weights,
) -> Option<(State, Weights)> {
    for round in 0..ROUNDS {
        if round > 0 {
            let noise = noise(&state, model, photos, &weights);
            let distances = state.distances(photos);
            for (weights, distances) in weights.iter_mut().zip(distances) {
                if weights.iter().all(|weight| *weight == 0.0) {
                    continue;
                }
                for (weight, distance) in weights.iter_mut().zip(distances) {
                    let far = distance / (CAUCHY * noise);
                    *weight = 1.0 / (1.0 + far * far);
                }
            }
        }
        state = state.descend(model, photos, &weights)?;
    }
    Some((state, weights))
}

/// Solves with the corners that are not too far off, until those are the same ones. Photos without any weight stay
/// out, as do those of which too few corners are left.
pub(crate) fn harden(
    mut state: State,
    model: Model,
    photos: &[Vec<Corner>],
    mut weights: Weights,
) -> Option<(State, Weights)> {
    for _ in 0..ROUNDS {
        let kept = keep(&state, model, photos, &weights);
        let same = kept == weights;
        weights = kept;
        if same {
            break;
        }
        state = state.descend(model, photos, &weights)?;
    }
    Some((state, weights))
}

fn keep(state: &State, model: Model, photos: &[Vec<Corner>], weights: &Weights) -> Weights {
    let noise = noise(state, model, photos, weights);
    let photo = |((distances, corners), weights): ((Vec<f64>, &Vec<Corner>), &Vec<f64>)| -> Vec<f64> {
        if weights.iter().all(|weight| *weight == 0.0) {
            return vec![0.0; corners.len()];
        }
        let limit = FARTHEST * photo_noise(&distances).clamp(noise, BLURRED * noise);
        let kept: Vec<f64> = distances.iter().map(|distance| f64::from(u8::from(*distance <= limit))).collect();
        if determines_pose(&counted(corners, &kept)) { kept } else { vec![0.0; corners.len()] }
    };
    state.distances(photos).into_iter().zip(photos).zip(weights).map(photo).collect()
}

/// The corners that count.
pub(crate) fn counted(corners: &[Corner], weights: &[f64]) -> Vec<Corner> {
    corners.iter().zip(weights).filter(|(_, weight)| **weight > 0.0).map(|(corner, _)| *corner).collect()
}

/// Whether the corners of a photo determine where the board is: six or more, not on a line.
#[must_use]
pub fn determines_pose(corners: &[Corner]) -> bool {
    corners.len() >= FEWEST && homography(corners).is_some()
}
