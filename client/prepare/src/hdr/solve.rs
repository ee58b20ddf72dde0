//! The response curve from a stack.

use super::patches::{Patch, patches};
use super::region::Region;
use super::response::{LEVELS, Response, place};
use super::stack::Stack;
use gonio_scene::SceneError;
use nalgebra::{DMatrix, DVector};

/// Weight of the second difference of what the curve has beside the plain one (lambda of equation 3), as a part of the
/// data's.
const SMOOTHNESS: f64 = 0.2;
/// Part of the data's largest say on the plain curve below which they say nothing: what is left of it goes on without
/// bends beyond the codes that a stack holds.
const INDISTINCT: f64 = 1e-5;
/// Residual, in ln(exposure), beyond which an observation counts less: what moved must not shape the curve.
const OUTLYING: f64 = 0.1;

/// Codes to either side of the middle one that say where a curve passes it.
const ABOUT_MIDDLE: usize = 32;

/// The value at code 128 of the parabola that fits a curve about it best (Savitzky and Golay's weights). The channels'
/// units hang on it: a single code's value has an error of half a per cent, by which the map would be tinted.
fn centre(g: &[f64]) -> f64 {
    let m = ABOUT_MIDDLE as f64;
    let norm = (2.0 * m - 1.0) * (2.0 * m + 1.0) * (2.0 * m + 3.0);
    let about = g[128 - ABOUT_MIDDLE..=128 + ABOUT_MIDDLE].iter().enumerate();
    let weight = |j: f64| (3.0 * (3.0 * m * m + 3.0 * m - 1.0) - 15.0 * j * j) / norm;
    about.map(|(k, value)| weight(k as f64 - m) * value).sum()
}

/// Learns the response of all three channels from the `region` of a stack: minimises
/// sum w(z)^2 [g(z_ij) - ln E_i - ln t_j]^2 + lambda^2 sum w(z)^2 (g - p)''(z)^2 (Debevec and Malik 1997, equation 3, where
/// p, the curve of six parameters that fits best, is 0) with g = 0 about code 128, reweighted so that few patches that moved
/// do not matter.
///
/// # Errors
/// No part of the region is exposed in two shots.
pub fn calibrate(stack: &Stack, region: Region) -> Result<Response, SceneError> {
    let mut tables = Vec::with_capacity(3);
    for channel in 0..3 {
        let patches = patches(stack, region, channel);
        if patches.len() < 20 {
            let name = stack.shots().first().map_or("PHOTOS", |shot| shot.name.as_str());
            let problem = format!(
                "and the other photos share {} patches of the region that are neither black nor saturated in two of them",
                patches.len()
            );
            return Err(
                SceneError::new(name, problem, "choose a larger --region, or nearer exposure times").at("region")
            );
        }
        let log_times: Vec<Option<f64>> = stack.log_times().into_iter().map(Some).collect();
        tables.push(solve(&patches, &log_times));
    }
    let mut tables = tables.into_iter();
    let mut next = || tables.next().unwrap_or_default();
    Ok(Response::new([next(), next(), next()]))
}

/// Debevec and Malik's hat: how much a value 0..1 is trusted.
pub(super) fn hat(value: f32) -> f64 {
    f64::from(value.min(1.0 - value).max(0.0)) * 2.0
}

/// ln E of a patch under a curve `g`, and its total weight; shots without a time are left out.
pub(super) fn log_radiance(g: &[f64], patch: &Patch, log_times: &[Option<f64>]) -> Option<f64> {
    let mut total = (0.0, 0.0);
    for (value, time) in patch.iter().zip(log_times) {
        if let (&Some(value), &Some(time)) = (value, time) {
            let weight = hat(value) * hat(value);
            total = (total.0 + weight * (at(g, value) - time), total.1 + weight);
        }
    }
    (total.1 > 0.0).then(|| total.0 / total.1)
}

/// A curve at a value 0..1.
pub(super) fn at(g: &[f64], value: f32) -> f64 {
    let (k, part) = place(value);
    g[k] + part * (g[k + 1] - g[k])
}

/// The curve of one channel; a shot whose time is none takes no part.
pub(super) fn solve(patches: &[Patch], log_times: &[Option<f64>]) -> Vec<f64> {
    let mut g = least_squares(patches, log_times, None);
    for _ in 0..3 {
        g = least_squares(patches, log_times, Some(&g));
    }
    g
}

/// The curve of few parameters that the data's normal equations like best: a power law, a polynomial and a shoulder,
/// a + b ln(v) + c v + d v^2 + e v^3 + f ln(1.1 - v) of a value v. Exposures a whole stop apart say nothing of a wave of
/// that period on the curve, and a plain smoothness would choose one that straightens the curve's steep foot; this has none.
fn plain(normal: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let value = |k: usize| (k as f64 + 0.5) / LEVELS as f64;
    let terms: [fn(f64) -> f64; 6] = [|_| 1.0, libm::log, |v| v, |v| v * v, |v| v * v * v, |v| libm::log(1.1 - v)];
    let mut basis = DMatrix::from_fn(LEVELS, terms.len(), |k, term| terms[term](value(k)));
    for mut column in basis.column_iter_mut() {
        let norm = column.norm();
        column.unscale_mut(norm);
    }
    let small = basis.transpose() * normal * &basis;
    let largest = small.diagonal().max();
    let shares = small.svd(true, true).solve(&(basis.transpose() * right), INDISTINCT * largest);
    shares.map_or_else(|_| DVector::zeros(LEVELS), |shares| basis * shares)
}

/// One solution of equation 3: the patches' ln E are eliminated, which leaves 256 unknowns however many patches there are.
fn least_squares(patches: &[Patch], log_times: &[Option<f64>], previous: Option<&[f64]>) -> Vec<f64> {
    let mut normal = DMatrix::<f64>::zeros(LEVELS, LEVELS);
    let mut right = DVector::<f64>::zeros(LEVELS);
    let mut terms: Vec<(usize, f64, f64, f64)> = Vec::new();
    let mut total = 0.0;
    for patch in patches {
        let radiance = previous.and_then(|g| log_radiance(g, patch, log_times));
        terms.clear();
        for (value, time) in patch.iter().zip(log_times) {
            let (&Some(value), &Some(time)) = (value, time) else { continue };
            let mut weight = hat(value) * hat(value);
            if let (Some(g), Some(radiance)) = (previous, radiance) {
                let residual = (at(g, value) - time - radiance) / OUTLYING;
                weight /= (1.0 + residual * residual) * (1.0 + residual * residual);
            }
            let (k, part) = place(value);
            terms.push((k, part, time, weight));
        }
        let sum: f64 = terms.iter().map(|term| term.3).sum();
        if terms.len() < 2 || sum <= 0.0 {
            continue;
        }
        total += sum;
        let mean_time = terms.iter().map(|term| term.3 * term.2).sum::<f64>() / sum;
        for &(k, part, time, weight) in &terms {
            for (a, share) in [(k, 1.0 - part), (k + 1, part)] {
                right[a] += weight * share * (time - mean_time);
                normal[(a, k)] += weight * share * (1.0 - part);
                normal[(a, k + 1)] += weight * share * part;
                for &(other, other_part, _, other_weight) in &terms {
                    let both = weight * share * other_weight / sum;
                    normal[(a, other)] -= both * (1.0 - other_part);
                    normal[(a, other + 1)] -= both * other_part;
                }
            }
        }
    }
    let scale = total.max(1.0) / LEVELS as f64;
    let plain = plain(&normal, &right);
    for k in 1..LEVELS - 1 {
        let hat = hat(k as f32 / 255.0).max(0.02);
        // In codes over 16, so that the weight reads as a part of the data's.
        let smooth = SMOOTHNESS * scale * hat * hat * 256.0;
        let bend = plain[k - 1] - 2.0 * plain[k] + plain[k + 1];
        for (a, left) in [(k - 1, 1.0), (k, -2.0), (k + 1, 1.0)] {
            right[a] += smooth * left * bend;
            for (b, other) in [(k - 1, 1.0), (k, -2.0), (k + 1, 1.0)] {
                normal[(a, b)] += smooth * left * other;
            }
        }
    }
    normal[(128, 128)] += total.max(1.0);
    // The tiniest part of the diagonal keeps the matrix positive definite where no patch has a code.
    for k in 0..LEVELS {
        normal[(k, k)] += 1e-12 * scale;
    }
    let solution = normal.cholesky().map(|factor| factor.solve(&right));
    // Never singular thanks to the terms above; a line is the neutral answer if rounding says otherwise.
    let g: Vec<f64> = solution.map_or_else(
        || (0..LEVELS).map(|k| (k as f64 - 128.0) / 64.0).collect(),
        |solution| solution.iter().copied().collect(),
    );
    let middle = centre(&g);
    g.into_iter().map(|value| value - middle).collect()
}
