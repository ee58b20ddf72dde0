//! Which model of the camera: the simplest that predicts photos which it was not fitted to as well as the best does.

use super::bundle::{State, Weights};
use super::model::Model;
use crate::board::Corner;

/// Parts into which the photos are dealt; each is predicted from the others.
const PARTS: usize = 6;

/// What a model says of photos that it was not fitted to.
struct Trial {
    model: Model,
    state: State,
    /// The sum of squares of each photo, pixels^2: the camera is the others', the pose its own.
    losses: Vec<f64>,
}

/// A model that was chosen.
pub(crate) struct Choice {
    pub(crate) model: Model,
    pub(crate) state: State,
    /// Root mean square distance of corners in photos that were left out, pixels.
    pub(crate) left_out: f64,
}

/// Chooses a model for the corners that count; absent where not even the simplest one is determined.
///
/// The loss of every photo left out is compared with that under the best model, pair by pair: a simpler model is taken
/// where what it loses is within one standard error of nothing (Breiman and others 1984, the rule of one standard error).
pub(crate) fn choose(start: &State, distortion: bool, photos: &[Vec<Corner>], weights: &Weights) -> Option<Choice> {
    let used: Vec<usize> =
        (0..photos.len()).filter(|&i| weights[i].iter().any(|weight| *weight > 0.0)).collect();
    let mut trials = Vec::new();
    for model in Model::choices(distortion) {
        let state = State { camera: model.cut(&start.camera), poses: start.poses.clone() };
        let Some(state) = state.descend(model, photos, weights) else { continue };
        let Some(losses) = predict(&state, model, photos, weights, &used) else {
            // What cannot be predicted with may still be all there is.
            if model == Model::PLAIN {
                trials.push(Trial { model, state, losses: vec![f64::INFINITY; used.len()] });
            }
            continue;
        };
        trials.push(Trial { model, state, losses });
    }
    let total = |trial: &Trial| trial.losses.iter().sum::<f64>();
    let best = trials.iter().min_by(|a, b| total(a).total_cmp(&total(b)))?;
    let as_good = |trial: &&Trial| {
        let differences: Vec<f64> = trial.losses.iter().zip(&best.losses).map(|(a, b)| a - b).collect();
        let (count, sum) = (differences.len() as f64, differences.iter().sum::<f64>());
        let mean = sum / count;
        let spread = differences.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>();
        // Standard error of a sum: its terms' standard deviation times sqrt(count).
        sum <= (spread / (count - 1.0) * count).sqrt()
    };
    let chosen = trials.iter().find(as_good).unwrap_or(best);
    let corners = weights.iter().flatten().filter(|weight| **weight > 0.0).count();
    let left_out = (total(chosen) / corners as f64).sqrt();
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
