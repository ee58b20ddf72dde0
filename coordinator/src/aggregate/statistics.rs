//! A tile's comparison with its photograph.
//!
//! Per observation (a pixel that counts, a colour channel) with half radiances `L_A`, `L_B`, exposure times gain `f`,
//! photo value `y` and response `r`:
//!
//! ```text
//! m = f (L_A + L_B) / 2,   M = r(m),   s = r'(m)
//! P_A = M + s (f L_A - m),  e_A = P_A - y,  D_A[j] = s * (column j of half A)      and B alike
//! gram += w (X_A Y_B + X_B Y_A) / 2   for X, Y in [e, D...]
//! ```
//!
//! The response is linearised at the mean, so that the two halves stay equally distributed about it and their product
//! carries no bias but the response's curvature over the render's noise. The halves are independent: E[e_A e_B] is the
//! squared error without the variance that a plain square has (Azinovic et al. 2019, "Inverse Path Tracing for Joint
//! Material and Lighting Estimation", section 5).
//!
//! The variance of `e_A e_B` that is due to the render: with e the true residual and each half's noise of variance q,
//! e_A e_B = e^2 + e (a + b) + a b, so the variance is 2 e^2 q + q^2. For Gaussian noise, mean and difference of the halves
//! are independent, hence E[((e_A + e_B) / 2)^2 (P_A - P_B)^2] = (e^2 + q / 2) 2 q: that product estimates it without bias.

use super::merge::MergedFilm;
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

/// Both halves' predictions of one observation.
#[derive(Debug, Clone, Copy)]
struct Prediction {
    /// Index of the pixel in the film.
    pixel: usize,
    /// Index of the pixel in the tile.
    index: usize,
    /// Photo value.
    measured: f64,
    /// M.
    mean: f64,
    /// s.
    slope: f64,
    /// P_A - P_B.
    difference: f64,
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
    for channel in 0..3 {
        compare_channel(film, observed, recipe, peak, channel, &mut sums);
    }
    sums
}

fn compare_channel(
    film: &MergedFilm,
    observed: Observed<'_>,
    recipe: &Recipe,
    peak: f64,
    channel: usize,
    sums: &mut PhotoStatistics,
) {
    let predictions = predict(film, observed, recipe, channel);
    let mut own = vec![None; observed.tile.len()];
    for p in &predictions {
        own[p.index] = Some(0.25 * p.difference * p.difference);
    }
    let variances = VarianceMap::new(observed.tile, &own);

    let active = &recipe.channels[channel];
    let side = 1 + active.len();
    let mut gram = vec![0.0; side * side];
    // Mean and half difference of the halves: (X_A Y_B + X_B Y_A) / 2 = mean_X mean_Y - half_X half_Y.
    let (mut mean, mut half) = (vec![0.0; side], vec![0.0; side]);
    let mut log_variance = LogSum::default();
    for p in &predictions {
        let (sensor, render) = (observed.sensor.variance(p.mean), variances.at(p.index));
        let w = weigh(sensor, render, peak).weight;
        let score = score(sensor, render, peak);
        mean[0] = p.mean - p.measured;
        half[0] = 0.5 * p.difference;
        let (a, b) = (film.pixel(0, p.pixel), film.pixel(1, p.pixel));
        for (j, column) in active.iter().enumerate() {
            let (mut column_a, mut column_b) = (0.0, 0.0);
            for (film_channel, factor) in &column.terms {
                column_a += factor * a[*film_channel];
                column_b += factor * b[*film_channel];
            }
            mean[1 + j] = p.slope * 0.5 * (column_a + column_b);
            half[1 + j] = p.slope * 0.5 * (column_a - column_b);
        }
        add_products(&mut gram, &mean, &half, w);
        let square = mean[0] * mean[0];
        sums.observations += 1;
        sums.chi_square += score.weight * square;
        sums.squared_error += square;
        log_variance.add(score.variance);
        sums.loss_variance += w * w * square * p.difference * p.difference;
        sums.peak = sums.peak.max(p.measured);
    }
    sums.log_variance += log_variance.finish();
    let full = 1 + recipe.columns;
    let place = |i: usize| if i == 0 { 0 } else { 1 + active[i - 1].column };
    for i in 0..side {
        for j in i..side {
            let (row, column) = (place(i), place(j));
            sums.gram[row * full + column] += gram[i * side + j];
            if row != column {
                sums.gram[column * full + row] += gram[i * side + j];
            }
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

fn predict(film: &MergedFilm, observed: Observed<'_>, recipe: &Recipe, channel: usize) -> Vec<Prediction> {
    let Observed { tile, pixels, photograph, .. } = observed;
    let mut predictions = Vec::with_capacity(film.pixels);
    for (pixel, index) in pixels.indices().enumerate() {
        let (x, y) = (tile.x as usize + index % tile.width as usize, tile.y as usize + index / tile.width as usize);
        let place = y * photograph.image.width as usize + x;
        if !photograph.counts[place] {
            continue;
        }
        let a = recipe.factor * film.pixel(0, pixel)[channel];
        let b = recipe.factor * film.pixel(1, pixel)[channel];
        let (mean, slope) = observed.sensor.response.apply(0.5 * (a + b));
        let measured = f64::from(photograph.image.pixels[place][channel]);
        predictions.push(Prediction { pixel, index, measured, mean, slope, difference: slope * (a - b) });
    }
    predictions
}

/// Adds `w (mean mean' - half half')` to the upper triangle of `gram`.
fn add_products(gram: &mut [f64], mean: &[f64], half: &[f64], w: f64) {
    let side = mean.len();
    for i in 0..side {
        let (wm, wh) = (w * mean[i], w * half[i]);
        let row = &mut gram[i * side + i..(i + 1) * side];
        for ((g, m), h) in row.iter_mut().zip(&mean[i..]).zip(&half[i..]) {
            *g += wm * m - wh * h;
        }
    }
}
