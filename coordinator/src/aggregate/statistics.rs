//! A tile's comparison with its photograph.
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
//! carries no bias but the stage's curvature over the render's noise. The halves are independent: E[e_A e_B] is the
//! squared error without the variance that a plain square has (Azinovic et al. 2019, "Inverse Path Tracing for Joint
//! Material and Lighting Estimation", section 5).
//!
//! The variance that a weight is made of is that of unclipped values: a mean that lies above a clip level by its noise alone is
//! no certain one, and a model would be punished for every such pixel that it clips.
//!
//! The variance of `e_A e_B` that is due to the render: with e the true residual and each half's noise of variance q,
//! e_A e_B = e^2 + e (a + b) + a b, so the variance is 2 e^2 q + q^2. For Gaussian noise, mean and difference of the halves
//! are independent, hence E[((e_A + e_B) / 2)^2 (P_A - P_B)^2] = (e^2 + q / 2) 2 q: that product estimates it without bias.

use super::gram::Gram;
use super::limit::limit;
use super::merge::MergedFilm;
use super::prediction::{Prediction, predict};
use super::recipe::Recipe;
use super::weight::{VarianceMap, score, weigh};
use gonio_scene::capture::Sensor;
use gonio_scene::film::{PixelSet, Tile};
use gonio_scene::{PhotoStatistics, Photograph};

/// A tile and what is known of it.
#[derive(Debug, Clone, Copy)]
pub struct Observed<'a> {
    /// Where it lies.
    pub tile: Tile,
    /// Its pixels that were rendered.
    pub pixels: &'a PixelSet,
    /// What was measured.
    pub photograph: &'a Photograph,
    /// How a value was measured.
    pub sensor: &'a Sensor,
}

/// The sums of one tile, in row order of its pixels.
///
/// `film` holds the two halves of the rendered pixels. Only the pixels among them that count are compared, and only they
/// speak about the render's noise: so it makes no difference whether others were rendered along.
#[must_use]
pub fn compare(film: &MergedFilm, observed: Observed<'_>, recipe: &Recipe, peak: f64) -> PhotoStatistics {
    let side = 1 + recipe.columns;
    let mut sums = PhotoStatistics {
        gram: vec![0.0; side * side],
        invalid_samples: film.invalid_samples,
        ..PhotoStatistics::default()
    };
    let predictions = predict(film, observed, recipe);
    for channel in 0..3 {
        compare_channel(film, observed, recipe, peak, channel, &predictions, &mut sums);
    }
    sums
}

fn compare_channel(
    film: &MergedFilm,
    observed: Observed<'_>,
    recipe: &Recipe,
    peak: f64,
    channel: usize,
    predictions: &[Prediction],
    sums: &mut PhotoStatistics,
) {
    let mut own = vec![None; observed.tile.len()];
    for p in predictions {
        own[p.index] = Some(0.25 * p.spread[channel] * p.spread[channel]);
    }
    let variances = VarianceMap::new(observed.tile, &own);

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
    let mut gram = Gram::new(1 + active.len());
    let mut log_variance = LogSum::default();
    // In registers while the loop runs; every sum still grows observation by observation.
    let (mut chi_square, mut squared_error) = (sums.chi_square, sums.squared_error);
    let (mut loss_variance, mut largest) = (sums.loss_variance, sums.peak);
    for (row, p) in predictions.iter().enumerate() {
        let (value, measured, difference) = (p.value[channel], p.measured[channel], p.difference[channel]);
        let (sensor, render) = (observed.sensor.variance(value), variances.at(p.index));
        let w = weigh(sensor, render, peak).weight;
        let score = score(sensor, render, peak);
        let residual = value - measured;
        gram.add(w, |i| match i.checked_sub(1) {
            None => (residual, 0.5 * difference),
            Some(j) => columns[j][row],
        });
        let square = residual * residual;
        chi_square += score.weight * square;
        squared_error += square;
        log_variance.add(score.variance);
        loss_variance += w * w * square * difference * difference;
        largest = largest.max(measured);
    }
    sums.observations += predictions.len() as u64;
    (sums.chi_square, sums.squared_error) = (chi_square, squared_error);
    (sums.loss_variance, sums.peak) = (loss_variance, largest);
    sums.log_variance += log_variance.finish();
    let full = 1 + recipe.columns;
    let place = |i: usize| if i == 0 { 0 } else { 1 + active[i - 1].column };
    for (i, j, sum) in gram.finish() {
        let (row, column) = (place(i), place(j));
        sums.gram[row * full + column] += sum;
        if row != column {
            sums.gram[column * full + row] += sum;
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
