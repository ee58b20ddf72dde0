//! Calibration: intrinsics, distortion and poses that minimise the reprojection error of corners that agree.

mod bundle;
mod model;
mod refusal;
mod robust;
mod select;
mod start;
mod zhang;

pub use model::Model;
pub use refusal::Refusal;
pub use robust::determines_pose;

use crate::board::Corner;
use crate::geometry::Pose;
use bundle::{OWN, State, Weights};
use gonio_scene::capture::Camera;
use model::SHARED;
use robust::{counted, harden, photo_noise, soften};

/// A photo's part of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotoFit {
    /// Board coordinates (metres; z into the board) to camera coordinates.
    pub board_to_camera: Pose,
    /// Root mean square distance of its corners from where they are predicted, pixels; of those that count, unless none does.
    pub error: f64,
    /// The largest of these distances, pixels.
    pub largest: f64,
    /// How many corners count; 0 where the photo contradicts the others, and was dropped.
    pub corners: usize,
    /// Numbers of the corners that contradict the others, and how far off each is, pixels. Empty where the photo was dropped.
    pub dropped: Vec<(u32, f64)>,
}

/// A calibrated camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Intrinsics and distortion.
    pub camera: Camera,
    /// Which of its numbers were looked for.
    pub model: Model,
    /// Standard errors of fx, fy, cx, cy (pixels) and k1 k2 p1 p2 k3, from the residuals and the curvature; 0 for what was
    /// not looked for.
    pub errors: [f64; 9],
    /// One per photo.
    pub photos: Vec<PhotoFit>,
    /// Root mean square distance over all corners that count, pixels; OpenCV's figure.
    pub error: f64,
    /// Root mean square distance over corners of photos that the camera was not fitted to, pixels; absent where it was given, or
    /// where too few photos are left to predict one.
    pub left_out: Option<f64>,
}

/// A photo that is so many times noisier than the median one contradicts the others: it was taken by another camera, with
/// another zoom, or shows the board bent.
const ODD: f64 = 5.0;
/// Below this, pixels, it may be blurred, and does no harm.
const HARMLESS: f64 = 1.0;
/// How often corners are dropped anew for the model that was chosen, and the model anew for the corners.
const TURNS: usize = 3;

/// Calibrates from the corners of every photo, all of `width` x `height` pixels: three photos of different directions or
/// more, of six corners each. Distortion is 0 unless `distortion` is set; then as many terms are used as predict photos
/// that were left out. Pixels are square unless photos that were left out say otherwise.
///
/// Corners, and photos, that contradict the others are dropped, and named in the result.
///
/// # Errors
/// Says which photo is no use, or that the photos do not determine a camera: in particular where a standard error is a
/// tenth of its number or more.
pub fn calibrate(width: u32, height: u32, photos: &[Vec<Corner>], distortion: bool) -> Result<Calibration, Refusal> {
    if photos.len() < 3 {
        return Err(Refusal::few(photos.len()));
    }
    let (state, weights) = start::cameras(width, height, photos)?;
    let (mut state, mut weights) = without_odd(state, weights, Model::ROUGH, photos)?;
    let mut chosen: Option<Model> = None;
    let mut left_out = None;
    for _ in 0..TURNS {
        let choice = select::choose(&state, distortion, photos, &weights).ok_or_else(Refusal::open)?;
        (state, left_out) = (choice.state, choice.left_out);
        let again = chosen.replace(choice.model) == Some(choice.model);
        let (next, kept) = harden(state.clone(), choice.model, photos, weights.clone()).ok_or_else(Refusal::open)?;
        let same = kept == weights;
        (state, weights) = (next, kept);
        if same || again {
            break;
        }
    }
    finish(&state, chosen.unwrap_or(Model::PLAIN), photos, &weights, left_out)
}

/// Where the board is in photos of a camera that is known. Corners that contradict the others are dropped.
///
/// # Errors
/// Says which photo does not determine a pose.
pub fn locate(camera: &Camera, photos: &[Vec<Corner>]) -> Result<Calibration, Refusal> {
    let (state, weights) = start::poses(camera, photos)?;
    let settled = soften(state, Model::POSES, photos, weights);
    let (state, weights) =
        settled.and_then(|(state, weights)| harden(state, Model::POSES, photos, weights)).ok_or_else(Refusal::open)?;
    finish(&state, Model::POSES, photos, &weights, None)
}

/// Solves, and drops the photo that is farthest off, until none is.
fn without_odd(
    mut state: State,
    mut weights: Weights,
    model: Model,
    photos: &[Vec<Corner>],
) -> Result<(State, Weights), Refusal> {
    loop {
        (state, weights) = soften(state, model, photos, weights).ok_or_else(Refusal::open)?;
        let used = |i: &usize| weights[*i].iter().any(|weight| *weight > 0.0);
        let distances = state.distances(photos);
        let mut noises: Vec<(f64, usize)> =
            (0..photos.len()).filter(used).map(|i| (photo_noise(&distances[i]), i)).collect();
        noises.sort_by(|a, b| a.0.total_cmp(&b.0));
        let median = noises.get(noises.len() / 2).map_or(0.0, |(noise, _)| *noise);
        match noises.last() {
            Some(&(noise, photo)) if noise > (ODD * median).max(HARMLESS) => {
                weights[photo].iter_mut().for_each(|weight| *weight = 0.0);
                let left = noises.len() - 1;
                // Where a third contradicts the rest, who is right cannot be told.
                if left < 3 || 3 * left < 2 * photos.len() {
                    return Err(Refusal::odd(photo, noise, median));
                }
            }
            _ => break,
        }
    }
    harden(state, model, photos, weights).ok_or_else(Refusal::open)
}

fn finish(
    state: &State,
    model: Model,
    photos: &[Vec<Corner>],
    weights: &Weights,
    left_out: Option<f64>,
) -> Result<Calibration, Refusal> {
    let count = weights.iter().flatten().filter(|weight| **weight > 0.0).count();
    let used = weights.iter().filter(|weights| weights.iter().any(|weight| *weight > 0.0)).count();
    let freedom = 2.0 * count as f64 - (OWN * used + model.columns()) as f64;
    if freedom <= 0.0 {
        return Err(Refusal::new(format!("{count} corners are fewer than the camera has unknowns: add photos")));
    }
    let cost: f64 = (photos.iter().zip(weights).enumerate()).map(|(i, (c, w))| state.photo_cost(i, c, w)).sum();
    let mut errors = [0.0; SHARED];
    if !model.given {
        let inverse = state.covariance(model, photos, weights).ok_or_else(Refusal::open)?;
        errors.iter_mut().enumerate().for_each(|(k, error)| *error = (inverse[(k, k)] * cost / freedom).sqrt());
        refusal::check(&state.camera, &errors)?;
    }
    // A photo without any corner that counts is placed by those it has, for the record.
    let left: Weights = (weights.iter())
        .map(|weights| vec![f64::from(u8::from(weights.iter().all(|weight| *weight == 0.0))); weights.len()])
        .collect();
    let placed = state.clone().descend(Model::POSES, photos, &left).unwrap_or_else(|| state.clone());
    let fit = |i: usize| {
        let (pose, distances) = match used_photo(&weights[i]) {
            true => (state.poses[i], state.distances(photos)),
            false => (placed.poses[i], placed.distances(photos)),
        };
        let distances = &distances[i];
        let counted = counted(&photos[i], &weights[i]).len();
        let counts: Vec<bool> = weights[i].iter().map(|weight| counted == 0 || *weight > 0.0).collect();
        let own = || distances.iter().zip(&counts).filter(|(_, counts)| **counts).map(|(distance, _)| *distance);
        let out = photos[i].iter().zip(distances).zip(&counts).filter(|(_, counts)| !**counts);
        PhotoFit {
            board_to_camera: pose,
            error: (own().map(|distance| distance * distance).sum::<f64>() / own().count() as f64).sqrt(),
            largest: own().fold(0.0, f64::max),
            corners: counted,
            dropped: out.map(|((corner, distance), _)| (corner.id, *distance)).collect(),
        }
    };
    let fits = (0..photos.len()).map(fit).collect();
    let error = (cost / count as f64).sqrt();
    Ok(Calibration { camera: state.camera.clone(), model, errors, photos: fits, error, left_out })
}

fn used_photo(weights: &[f64]) -> bool {
    weights.iter().any(|weight| *weight > 0.0)
}
