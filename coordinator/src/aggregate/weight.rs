//! The variance of a residual: the sensor's, and the render's own noise, estimated from its two halves.

use gonio_scene::film::Tile;
use std::sync::LazyLock;

/// Half the side of the window over which the render's variance is averaged: 5x5 pixels.
const RADIUS: usize = 2;

/// A window with fewer other pixels than this says too little: its pixel takes the whole tile's instead.
const FEWEST: f64 = 8.0;

/// Smallest variance relative to the square of the photo's peak, for a sensor that claims to be without noise in the dark.
const SMALLEST: f64 = 1e-12;

/// The render's variance at one observation, and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderVariance {
    /// Variance of the mean of the halves, by the neighbours.
    pub value: f64,
    /// The pixel's own (A - B)^2 / 4: one degree of freedom.
    pub own: f64,
    /// Independent pixels that it was estimated from; at least 1.
    pub pixels: f64,
}

/// Estimates of the render's variance around every pixel of a tile, in one colour channel.
///
/// (A - B)^2 / 4 is an unbiased estimate of the variance of (A + B) / 2, but from one pixel it is far too noisy for a
/// weight, and depends on that pixel's own residual: a weight made of it would favour pixels whose halves agree by
/// chance. So a pixel takes the mean over its neighbours, without itself.
#[derive(Debug)]
pub struct VarianceMap {
    width: usize,
    /// Per tile pixel, with a border of `RADIUS` pixels of zeros, so that no window needs to look where the tile ends.
    own: Grid,
    /// Sums over each pixel's row of the window.
    rows: Grid,
    total: Sum,
}

/// A sum over pixels that count, and their number.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Sum {
    value: f64,
    pixels: f64,
}

impl std::ops::Add for Sum {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, pixels: self.pixels + other.pixels }
    }
}

#[derive(Debug)]
struct Grid {
    stride: usize,
    sums: Vec<Sum>,
}

impl VarianceMap {
    /// A map of `own` estimates ((A - B)^2 / 4, or `None` where a pixel does not count), row-major over `tile`.
    #[must_use]
    pub fn new(tile: Tile, own: &[Option<f64>]) -> Self {
        let (width, height) = (tile.width as usize, tile.height as usize);
        let stride = width + 2 * RADIUS;
        let mut grid = Grid { stride, sums: vec![Sum::default(); stride * (height + 2 * RADIUS)] };
        let mut total = Sum::default();
        for (y, row) in own.chunks_exact(width).enumerate() {
            for (x, value) in row.iter().enumerate() {
                if let Some(value) = *value {
                    let sum = Sum { value, pixels: 1.0 };
                    grid.sums[(y + RADIUS) * stride + x + RADIUS] = sum;
                    total = total + sum;
                }
            }
        }
        let mut rows = Grid { stride, sums: vec![Sum::default(); grid.sums.len()] };
        for (i, window) in grid.sums.windows(2 * RADIUS + 1).enumerate() {
            rows.sums[i + RADIUS] = window.iter().fold(Sum::default(), |sum, own| sum + *own);
        }
        Self { width, own: grid, rows, total }
    }

    /// The estimate for tile pixel `index`, which counts.
    #[must_use]
    pub fn at(&self, index: usize) -> RenderVariance {
        let stride = self.own.stride;
        let centre = (index / self.width + RADIUS) * stride + index % self.width + RADIUS;
        let own = self.own.sums[centre].value;
        // Left out by not being added: to add and subtract it would lose the digits of quiet neighbours.
        let mut nearby = Sum::default();
        for distance in 1..=RADIUS {
            nearby = nearby + self.rows.sums[centre - distance * stride] + self.rows.sums[centre + distance * stride];
            nearby = nearby + self.own.sums[centre - distance] + self.own.sums[centre + distance];
        }
        if nearby.pixels < FEWEST && self.total.pixels > nearby.pixels + 1.0 {
            // Here the subtraction may leave a rounding error below zero.
            nearby = Sum { value: (self.total.value - own).max(0.0), pixels: self.total.pixels - 1.0 };
        }
        if nearby.pixels == 0.0 {
            return RenderVariance { value: own, own, pixels: 1.0 };
        }
        RenderVariance { value: nearby.value / nearby.pixels, own, pixels: nearby.pixels }
    }
}

/// The weight of an observation and the variance that it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weight {
    /// Factor on the squared residual.
    pub weight: f64,
    /// Sensor variance plus render variance.
    pub variance: f64,
}

/// The weight 1 / (sensor + render), corrected for the render's variance being an estimate.
///
/// The mean of 1 / V over estimates V is larger than 1 / (mean of V): by the factor 1 + Var V / V^2 to second order, where
/// Var V = 2 r^2 / n for a render variance r from n Gaussian pixels. Without the correction a chi-square would exceed its
/// expectation by 9 % where the render's noise dominates. `peak` is the photo's largest value.
#[must_use]
pub fn weigh(sensor: f64, render: RenderVariance, peak: f64) -> Weight {
    let variance = (sensor + render.value).max(SMALLEST * peak * peak).max(f64::MIN_POSITIVE.sqrt());
    let share = render.value / variance;
    let excess = 2.0 / render.pixels * share * share;
    Weight { weight: 1.0 / (variance * (1.0 + excess)), variance }
}

/// The weight of a squared residual in a chi-square, which, unlike a fit, may look at the pixel's own noise.
///
/// At silhouettes and in caustics a pixel's noise is a hundred times its neighbours', whose mean then says nothing; the
/// pixel's own estimate says it with one degree of freedom X. The mean of both stays in bounds everywhere. With a render's
/// share s of the variance and Gaussian noise 1 / V then has the mean g(s) = E[1 / (1 - s + s (1 + X) / 2)], 1.31 at
/// s = 1, which is divided out, as is the neighbours' own noise to second order.
#[must_use]
pub fn score(sensor: f64, render: RenderVariance, peak: f64) -> Weight {
    let smallest = (SMALLEST * peak * peak).max(f64::MIN_POSITIVE.sqrt());
    let variance = (sensor + 0.5 * (render.own + render.value)).max(smallest);
    // From the neighbours alone, so that the correction does not depend on the noise that it corrects for.
    let share = render.value / (sensor + render.value).max(smallest);
    let neighbours = 1.0 + 0.9 / render.pixels * share * share;
    Weight { weight: 1.0 / (variance * EXCESS.at(share) * neighbours), variance }
}

/// g(s): E[1 / (a + X)] = sqrt(pi / 2a) exp(a / 2) erfc(sqrt(a / 2)) with a = (2 - s) / s.
fn excess(share: f64) -> f64 {
    if share < 0.05 {
        // Its series, where the closed form loses its digits: 1 + s^2 Var((1 + X) / 2).
        return 1.0 + 0.5 * share * share;
    }
    let a = (2.0 - share) / share;
    let mean = (std::f64::consts::PI / (2.0 * a)).sqrt() * libm::exp(0.5 * a) * libm::erfc((0.5 * a).sqrt());
    2.0 / share * mean
}

/// [`excess`] at equal steps of the share, as every observation needs it once.
static EXCESS: LazyLock<Table> = LazyLock::new(|| Table(std::array::from_fn(|i| excess(i as f64 / STEPS as f64))));

const STEPS: usize = 256;

struct Table([f64; STEPS + 1]);

impl Table {
    /// Interpolated linearly: within 5e-6 of the function.
    fn at(&self, share: f64) -> f64 {
        let place = share.clamp(0.0, 1.0) * STEPS as f64;
        let below = (place as usize).min(STEPS - 1);
        let (a, b) = (self.0[below], self.0[below + 1]);
        a + (place - below as f64) * (b - a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: Tile = Tile { x: 0, y: 0, width: 6, height: 7 };

    #[test]
    fn a_window_leaves_its_own_pixel_out() {
        let mut own = vec![Some(1.0); 42];
        own[3 * 6 + 3] = Some(1000.0);
        let map = VarianceMap::new(TILE, &own);
        assert_eq!(map.at(3 * 6 + 3), RenderVariance { value: 1.0, own: 1000.0, pixels: 24.0 });
        assert_eq!(map.at(3 * 6 + 2), RenderVariance { value: 1023.0 / 24.0, own: 1.0, pixels: 24.0 });
        assert_eq!(map.at(0), RenderVariance { value: 1.0, own: 1.0, pixels: 8.0 });
    }

    #[test]
    fn only_pixels_that_count_speak() {
        let mut own = vec![None; 42];
        own[0] = Some(4.0);
        assert_eq!(VarianceMap::new(TILE, &own).at(0), RenderVariance { value: 4.0, own: 4.0, pixels: 1.0 });
        own[41] = Some(2.0);
        assert_eq!(VarianceMap::new(TILE, &own).at(0), RenderVariance { value: 2.0, own: 4.0, pixels: 1.0 });
        own[40] = Some(4.0);
        assert_eq!(VarianceMap::new(TILE, &own).at(0), RenderVariance { value: 3.0, own: 4.0, pixels: 2.0 });
    }

    /// The mean of 1 / V over chi-square noise, by quadrature over the normal deviate, is undone at every share.
    #[test]
    fn the_correction_makes_scores_unbiased() {
        for share in [0.01, 0.049, 0.051, 0.2, 0.5, 0.9, 1.0] {
            let (mut mean, mut mass) = (0.0, 0.0);
            for k in -4000..=4000 {
                let z = f64::from(k) * 0.002;
                let density = libm::exp(-0.5 * z * z);
                let render = RenderVariance { own: share * z * z, value: share, pixels: 1e9 };
                mean += density * score(1.0 - share, render, 0.0).weight;
                mass += density;
            }
            assert!((mean / mass - 1.0).abs() < 2e-4, "share {share}: {}", mean / mass);
        }
    }

    #[test]
    fn a_sensor_without_noise_gets_no_infinite_weight() {
        let weight = weigh(0.0, RenderVariance { value: 0.0, own: 0.0, pixels: 24.0 }, 2.0);
        assert_eq!(weight.variance, 4e-12);
        assert!(weigh(0.0, RenderVariance { value: 0.0, own: 0.0, pixels: 24.0 }, 0.0).weight.is_finite());
    }
}
