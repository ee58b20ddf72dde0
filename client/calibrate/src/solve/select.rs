//! Which model of the camera: the simplest that predicts photos which it was not fitted to as well as the best does.

use super::bundle::{State, Weights};
use super::model::Model;
use crate::board::Corner;

/// Parts into which the photos are dealt; each is predicted from the others.
const PARTS: usize = 6;

/// What a simpler model may lose to the best one, in standard errors of the difference. With 1 (Breiman and others 1984),
/// OpenCV's four photos that the tests read lose a distortion whose loss is a twentieth lower. Of the 20 sets of
/// `tests/covered.rs` at twice their noise, two take k3 with 0, and none with 0.5.
const AS_GOOD: f64 = 0.5;
/// What pixels that are not square must gain, in standard errors: hardly any sensor has them, and where photos say little,
/// an aspect ratio that is free costs half of the accuracy of the focal length.
const NOT_SQUARE: f64 = 2.0;

/// What a model says of photos that it was not fitted to.
struct Trial {
    model: Model,
    state: State,
    /// The sum of squares of each photo, pixels^2: the camera is the others', the pose its own.
    losses: Vec<f64>,
}

impl Trial {
    fn total(&self) -> f64 {
        self.losses.iter().sum()
    }

    /// What this loses to `other`, in standard errors of the difference, photo by photo.
    fn loses(&self, other: &Self) -> f64 {
        let differences: Vec<f64> = self.losses.iter().zip(&other.losses).map(|(a, b)| a - b).collect();
        let (count, sum) = (differences.len() as f64, differences.iter().sum::<f64>());
        let mean = sum / count;
        let spread = differences.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>();
        // Standard error of a sum: its terms' standard deviation times sqrt(count).
        let error = (spread / (count - 1.0) * count).sqrt();
        if sum == 0.0 { 0.0 } else { sum / error }
    }
}

/// A model that was chosen.
pub(crate) struct Choice {
    pub(crate) model: Model,
    pub(crate) state: State,
    /// Root mean square distance of corners in photos that were left out, pixels; absent where none could be predicted.
    pub(crate) left_out: Option<f64>,
}

/// Chooses a model for the corners that count; absent where not even the simplest one is determined.
///
/// The losses of photos left out are compared pair by pair: the simplest model is taken that is as good as the best one,
/// and pixels that are not square only where they predict far better.
pub(crate) fn choose(start: &State, distortion: bool, photos: &[Vec<Corner>], weights: &Weights) -> Option<Choice> {
    let used: Vec<usize> = (0..photos.len()).filter(|&i| weights[i].iter().any(|weight| *weight > 0.0)).collect();
    let mut trials = Vec::new();
    for model in Model::choices(distortion) {
        let state = State { camera: model.cut(&start.camera), poses: start.poses.clone() };
        let Some(state) = state.descend(model, photos, weights) else { continue };
        if let Some(losses) = predict(&state, model, photos, weights, &used) {
            trials.push(Trial { model, state, losses });
        }
    }
    if trials.is_empty() {
        // What cannot be predicted with may still be all there is; its errors will say.
        let state = State { camera: Model::PLAIN.cut(&start.camera), poses: start.poses.clone() };
        let state = state.descend(Model::PLAIN, photos, weights)?;
        return Some(Choice { model: Model::PLAIN, state, left_out: None });
    }
    let family = |square: bool| {
        let own = || trials.iter().filter(move |trial| trial.model.square == square);
        let best = own().min_by(|a, b| a.total().total_cmp(&b.total()))?;
        own().find(|trial| trial.loses(best) <= AS_GOOD)
    };
    let chosen = match (family(true), family(false)) {
        (Some(square), Some(free)) if square.loses(free) > NOT_SQUARE => free,
        (square, free) => square.or(free)?,
    };
    let corners = weights.iter().flatten().filter(|weight| **weight > 0.0).count();
    let left_out = Some((chosen.total() / corners as f64).sqrt());
    Some(Choice { model: chosen.model, state: chosen.state.clone(), left_out })
}

/// The loss of each of the photos `used`, each predicted from the other parts; absent where they do not determine `model`.
fn predict(state: &State, model: Model, photos: &[Vec<Corner>], weights: &Weights, used: &[usize]) -> Option<Vec<f64>> {
    let parts = PARTS.min(used.len());
    let mut losses = vec![0.0; used.len()];
    for part in 0..parts {
        let mut others = weights.clone();
        let mut own: Weights = weights.iter().map(|weights| vec![0.0; weights.len()]).collect();
        for &photo in used.iter().skip(part).step_by(parts) {
            std::mem::swap(&mut others[photo], &mut own[photo]);
        }
        let fitted = state.clone().descend(model, photos, &others)?;
        let fitted = fitted.descend(Model::POSES, photos, &own)?;
        for (place, &photo) in used.iter().enumerate().skip(part).step_by(parts) {
            losses[place] = fitted.photo_cost(photo, &photos[photo], &own[photo]);
        }
    }
    losses.iter().all(|loss| loss.is_finite()).then_some(losses)
}
