//! A tile's comparison with its photograph: the sums of [`gonio_scene::statistics`], where weights and loss are derived.
//!
//! Per observation (a pixel that counts, a colour channel c) with exposed light `l_A`, `l_B` of the halves (three channels
//! each), photo value `y` and sensor stage `V`:
//!
//! ```text
//! m = (l_A + l_B) / 2,   M = V(m)_c,   S = row c of V'(m)
//! P_A = M + S (l_A - m),  e_A = P_A - y,  D_A[j] = d P_A / d j      and B alike
//! gram += w (X_A Y_B + X_B Y_A) / 2   for X, Y in [e, D...]
//! ```
//!
//! D_A[j] is S times column j of half A where j moves the light, and (dV/dj)(m)_c + (dS/dj) (l_A - m) where j is a number of
//! the sensor, by differences of V and V'.
//!
//! The stage is linearised at the mean, so that the two halves stay equally distributed about it and their product
//! carries no bias but the stage's curvature over the render's noise.
//!
//! The covariance of the Gram matrix's first column that is due to the render: let x, y, a be the noise of X, Y, e in half A, and
//! Q their covariance. Then the covariance of (X_A e_B + X_B e_A) / 2 with the same of Y is
//!
//! ```text
//! (X Y Q_ee + X e Q_ey + e Y Q_xe + e e Q_xy) / 2 + (Q_xy Q_ee + Q_xe Q_ye) / 2
//! ```
//!
//! (for X = Y = e: 2 e^2 q + q^2). Means over the halves have covariance X Y + Q_xy / 2, half differences (A - B) / 2 have Q_xy / 2. So
//! the expectation of u_X u_Y, with u_X = mean_X half_e' + half_X' mean_e, is just that, if the differences ' come from another pixel
//! of the same noise: from the pixel's own, u would hold fourth moments, which a rare bright path (a firefly) makes
//! many times too large, where the product across halves is linear in it. The other pixel is the neighbour whose photo value is
//! nearest ([`super::partner`]): along an edge another pixel of the edge. A pixel's channels come from the same paths, so u is
//! summed over them first: noise += u_X u_Y.
//!
//! A pixel that was drawn with probability p stands for h = 1 / p: every sum above takes it h times, and `noise`, a variance, h^2
//! times (of drawn pixels the next one lies further away: its noise is like the pixel's own in the mean of a tile). What the draw itself adds to the covariance of J'We is left to the right model's residuals, of variance 1 / w, and
//! Poisson sampling: the estimate's covariance is the sum of h^2 w D D', of which `gram` holds h w D D', so the rest is
//! draw += (h^2 - h) w (D_A D_B' + D_B D_A') / 2 (Saerndal, Swensson and Wretman 1992, "Model Assisted Survey Sampling",
//! section 3.2, for the variance of the sum; its expectation under the model is what is summed here).

use super::gram::Gram;
use super::limit::limit;
use super::measured::Measured;
use super::merge::MergedFilm;
use super::partner::partners;
use super::prediction::{Prediction, predict};
use super::recipe::Recipe;
use gonio_scene::PhotoStatistics;
use gonio_scene::capture::Sensor;
use gonio_scene::film::{PixelSet, Tile};

/// Smallest variance relative to the square of the photo's peak, for a sensor that claims to be without noise in the dark.
const SMALLEST: f64 = 1e-12;

/// A tile and what is known of it.
#[derive(Debug, Clone, Copy)]
pub struct Observed<'a> {
    /// Where it lies.
    pub tile: Tile,
    /// Its pixels that were rendered.
    pub pixels: &'a PixelSet,
    /// What was measured.
    pub photograph: &'a Measured,
    /// How a value was measured.
    pub sensor: &'a Sensor,
}

/// The sums of one tile, in row order of its pixels.
///
/// `film` holds the two halves of the rendered pixels. Only the pixels among them that count are compared, and only they
/// speak about the render's noise: so it makes no difference whether others were rendered along. `peak` is the photo's largest
/// value.
#[must_use]
pub fn compare(film: &MergedFilm, observed: Observed<'_>, recipe: &Recipe, peak: f64) -> PhotoStatistics {
    let side = 1 + recipe.columns;
    let is_drawn = matches!(observed.photograph, Measured::Drawn(_));
    let mut sums = PhotoStatistics {
        gram: vec![0.0; side * side],
        noise: vec![0.0; side * side],
        draw: if is_drawn { vec![0.0; side * side] } else { Vec::new() },
        invalid_samples: film.invalid_samples,
        ..PhotoStatistics::default()
    };
    let predictions = predict(film, observed, recipe);
    // u of each pixel, summed over its channels.
    let mut moves = vec![0.0; predictions.len() * side];
    let partners = partners(observed.tile, &predictions);
    for channel in 0..3 {
        compare_channel(film, observed, recipe, peak, channel, &predictions, &partners, &mut moves, &mut sums);
    }
    let mut noise = Gram::new(side);
    for (row, p) in moves.chunks_exact(side).zip(&predictions) {
        noise.add(p.weight * p.weight, |i| (row[i], 0.0));
    }
    spread(noise, side, |i| i, &mut sums.noise);
    sums
}

#[allow(clippy::too_many_arguments)] // What a channel needs of its tile, and the two sums that channels share.
fn compare_channel(
    film: &MergedFilm,
    observed: Observed<'_>,
    recipe: &Recipe,
    peak: f64,
    channel: usize,
    predictions: &[Prediction],
    partners: &[usize],
    moves: &mut [f64],
    sums: &mut PhotoStatistics,
) {
    let active = &recipe.channels[channel];
    let mut columns: Vec<Vec<(f64, f64)>> = active.iter().map(|_| Vec::with_capacity(predictions.len())).collect();
    // Pixel by pixel, as the film lies in memory: a hundred columns of it are larger than a cache.
    for p in predictions {
        let halves = [film.pixel(0, p.pixel), film.pixel(1, p.pixel)];
        for (values, column) in columns.iter_mut().zip(active) {
            values.push(p.column(channel, column, halves));
        }
    }
    for values in &mut columns {
        limit(observed.tile, predictions.iter().map(|p| p.index), values);
    }
    let side = 1 + recipe.columns;
    let place = |i: usize| if i == 0 { 0 } else { 1 + active[i - 1].column };
    let smallest = (SMALLEST * peak * peak).max(f64::MIN_POSITIVE.sqrt());
    let mut gram = Gram::new(1 + active.len());
    let mut draw = (!sums.draw.is_empty()).then(|| Gram::new(1 + active.len()));
    let mut log_variance = LogSum::default();
    let (mut weighted_log, mut weight) = (0.0, 0.0);
    for (row, p) in predictions.iter().enumerate() {
        let (measured, half) = (p.measured[channel], 0.5 * p.difference[channel]);
        let variance = observed.sensor.variance(p.surroundings[channel]).max(smallest);
        let w = 1.0 / variance;
        let residual = p.value[channel] - measured;
        let other = partners[row];
        let half_of_other = 0.5 * predictions[other].difference[channel];
        let moved = &mut moves[row * side..(row + 1) * side];
        let h = p.weight;
        gram.add(h * w, |i| {
            let (value, noise) = match i.checked_sub(1) {
                None => ((residual, half), half_of_other),
                Some(j) => (columns[j][row], columns[j][other].1),
            };
            moved[place(i)] += w * (value.0 * half_of_other + noise * residual);
            value
        });
        if let Some(draw) = &mut draw {
            // The residual's own row and column are left out: its part is known to be that of the right model.
            draw.add((h * h - h) * w, |i| i.checked_sub(1).map_or((0.0, 0.0), |j| columns[j][row]));
            weighted_log += h * libm::log(variance);
        } else {
            log_variance.add(variance);
        }
        weight += h;
        sums.noise_floor += h * (w * observed.sensor.variance(measured).max(smallest));
        sums.render_noise += h * (w * half * half);
        sums.squared_error += h * (residual * residual - half * half);
        sums.peak = sums.peak.max(measured);
    }
    sums.observations += weight.round() as u64;
    sums.compared += predictions.len() as u64;
    sums.log_variance += log_variance.finish() + weighted_log;
    spread(gram, side, place, &mut sums.gram);
    if let Some(draw) = draw {
        spread(draw, side, place, &mut sums.draw);
    }
}

/// Adds a triangle of sums to a symmetric matrix of `side` rows, row `i` of the triangle at `place(i)`.
fn spread(gram: Gram, side: usize, place: impl Fn(usize) -> usize, matrix: &mut [f64]) {
    for (i, j, sum) in gram.finish() {
        let (row, column) = (place(i), place(j));
        matrix[row * side + column] += sum;
        if row != column {
            matrix[column * side + row] += sum;
        }
    }
}

/// A sum of logarithms by the logarithm of a product: one for a dozen factors.
struct LogSum {
    sum: f64,
    product: f64,
}

impl Default for LogSum {
    fn default() -> Self {
        Self { sum: 0.0, product: 1.0 }
    }
}

impl LogSum {
    /// Adds the logarithm of a number between 1e-154 and 1e154.
    fn add(&mut self, factor: f64) {
        self.product *= factor;
        if !(1e-150..=1e150).contains(&self.product) {
            self.sum += libm::log(self.product);
            self.product = 1.0;
        }
    }

    fn finish(self) -> f64 {
        self.sum + libm::log(self.product)
    }
}
