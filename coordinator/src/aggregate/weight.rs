//! The variance of a residual: the sensor's, and the render's own noise, estimated from its two halves.

use gonio_scene::film::Tile;

/// Half the side of the window over which the render's variance is averaged: 5x5 pixels.
const RADIUS: u32 = 2;

/// A window with fewer other pixels than this says too little: its pixel takes the whole tile's instead.
const FEWEST: u32 = 8;

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
    tile: Tile,
    /// Per tile pixel: (A - B)^2 / 4, or `None` where the pixel does not count.
    own: Vec<Option<f64>>,
    total: f64,
    count: u32,
}

impl VarianceMap {
    /// A map of `own` estimates, row-major over `tile`.
    #[must_use]
    pub fn new(tile: Tile, own: Vec<Option<f64>>) -> Self {
        let (total, count) = own.iter().flatten().fold((0.0, 0), |(total, count), v| (total + v, count + 1));
        Self { tile, own, total, count }
    }

    /// The estimate for tile pixel `index`, which counts.
    #[must_use]
    pub fn at(&self, index: usize) -> RenderVariance {
        let own = self.own[index].unwrap_or(0.0);
        let width = self.tile.width;
        let (x, y) = (index as u32 % width, index as u32 / width);
        let (mut total, mut count) = (0.0, 0_u32);
        for j in y.saturating_sub(RADIUS)..(y + RADIUS + 1).min(self.tile.height) {
            for i in x.saturating_sub(RADIUS)..(x + RADIUS + 1).min(width) {
                if let (Some(value), true) = (self.own[(j * width + i) as usize], (i, j) != (x, y)) {
                    total += value;
                    count += 1;
                }
            }
        }
        if count < FEWEST && self.count > count + 1 {
            // Subtraction may leave a rounding error below zero.
            (total, count) = ((self.total - own).max(0.0), self.count - 1);
        }
        if count == 0 {
            return RenderVariance { value: own, own, pixels: 1.0 };
        }
        RenderVariance { value: total / f64::from(count), own, pixels: f64::from(count) }
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
    Weight { weight: 1.0 / (variance * excess(share) * neighbours), variance }
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

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: Tile = Tile { x: 0, y: 0, width: 6, height: 7 };

    #[test]
    fn a_window_leaves_its_own_pixel_out() {
        let mut own = vec![Some(1.0); 42];
        own[3 * 6 + 3] = Some(1000.0);
        let map = VarianceMap::new(TILE, own);
        assert_eq!(map.at(3 * 6 + 3), RenderVariance { value: 1.0, own: 1000.0, pixels: 24.0 });
        assert_eq!(map.at(3 * 6 + 2), RenderVariance { value: 1023.0 / 24.0, own: 1.0, pixels: 24.0 });
        assert_eq!(map.at(0), RenderVariance { value: 1.0, own: 1.0, pixels: 8.0 });
    }

    #[test]
    fn only_pixels_that_count_speak() {
        let mut own = vec![None; 42];
        own[0] = Some(4.0);
        assert_eq!(VarianceMap::new(TILE, own.clone()).at(0), RenderVariance { value: 4.0, own: 4.0, pixels: 1.0 });
        own[41] = Some(2.0);
        assert_eq!(VarianceMap::new(TILE, own.clone()).at(0), RenderVariance { value: 2.0, own: 4.0, pixels: 1.0 });
        own[40] = Some(4.0);
        assert_eq!(VarianceMap::new(TILE, own).at(0), RenderVariance { value: 3.0, own: 4.0, pixels: 2.0 });
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
