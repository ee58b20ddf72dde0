//! How a surface of one colour looks under light from far away: its radiance is nearly a quadratic polynomial of the
//! normal (Ramamoorthi & Hanrahan 2001), whose nine coefficients for each channel an image determines.

use glam::DVec3;
use nalgebra::{SMatrix, SVector};

/// Coefficients of a channel.
const TERMS: usize = 9;

/// What holds the coefficients back where few normals are seen, for each pixel.
const RIDGE: f64 = 1e-3;

/// Times that outliers (highlights, shadows that the part casts on itself, whatever is in front) are weighed down.
const ROUNDS: usize = 2;

/// Least spread of values about the polynomial.
const LEAST: f64 = 0.03;

/// A shading that was fitted.
#[derive(Debug, Clone)]
pub(crate) struct Shading {
    coefficients: SMatrix<f64, TERMS, 3>,
    /// Standard deviation of the values about it, of all three channels.
    pub spread: f64,
}

impl Shading {
    /// The shading of `pixels`: unit normals in camera coordinates, and values. `None` for too few of them.
    pub fn fit(pixels: &[(DVec3, [f32; 3])]) -> Option<Self> {
        if pixels.len() < 2 * TERMS {
            return None;
        }
        let mut shading = Self { coefficients: SMatrix::zeros(), spread: f64::INFINITY };
        for _ in 0..=ROUNDS {
            let mut left = SMatrix::<f64, TERMS, TERMS>::zeros();
            let mut right = SMatrix::<f64, TERMS, 3>::zeros();
            for (normal, value) in pixels {
                let terms = terms(*normal);
                let weight = if shading.spread.is_finite() {
                    let ratio = shading.squared(&terms, value) / (9.0 * shading.spread * shading.spread);
                    1.0 / (1.0 + ratio * ratio)
                } else {
                    1.0
                };
                left.ger(weight, &terms, &terms, 1.0);
                let value = SVector::from(value.map(f64::from));
                right.ger(weight, &terms, &value, 1.0);
            }
            #[allow(clippy::cast_precision_loss)]
            let ridge = RIDGE * pixels.len() as f64;
            for i in 1..TERMS {
                left[(i, i)] += ridge;
            }
            shading.coefficients = left.cholesky()?.solve(&right);
            let mut squares: Vec<f64> = pixels.iter().map(|(n, value)| shading.squared(&terms(*n), value)).collect();
            let middle = squares.len() / 2;
            // The median of chi-square with three degrees of freedom is 2.366.
            let median = *squares.select_nth_unstable_by(middle, f64::total_cmp).1;
            shading.spread = (median / 2.366).sqrt().max(LEAST);
        }
        Some(shading)
    }

    /// Sum over the channels of the squared distance from a value.
    fn squared(&self, terms: &SVector<f64, TERMS>, value: &[f32; 3]) -> f64 {
        let mut sum = 0.0;
        for (channel, value) in value.iter().enumerate() {
            let difference = f64::from(*value) - self.coefficients.column(channel).dot(terms);
            sum += difference * difference;
        }
        sum
    }

    /// The logarithm of the density of a value where the surface has a normal, outliers aside.
    pub fn logarithm(&self, normal: DVec3, value: &[f32; 3]) -> f64 {
        let scale = -3.0 * libm::log(self.spread * (2.0 * std::f64::consts::PI).sqrt());
        scale - self.squared(&terms(normal), value) / (2.0 * self.spread * self.spread)
    }
}

fn terms(n: DVec3) -> SVector<f64, TERMS> {
    SVector::from([1.0, n.x, n.y, n.z, n.x * n.y, n.y * n.z, n.x * n.z, n.x * n.x - n.y * n.y, 3.0 * n.z * n.z - 1.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lambertian_part_is_its_shading_and_outliers_are_none_of_it() {
        let mut pixels = Vec::new();
        for i in 0..40 {
            for j in 0..10 {
                let (sine, cosine) = libm::sincos(f64::from(i) * 0.157);
                let height = -0.05 - 0.09 * f64::from(j);
                let ring = (1.0f64 - height * height).sqrt();
                let normal = DVec3::new(ring * cosine, ring * sine, height);
                let value = 0.3 - 0.2 * normal.z + 0.1 * normal.x * normal.y;
                let value = if (i * 10 + j) % 9 == 0 { 1.0 } else { value };
                pixels.push((normal, [value as f32, 0.5 * value as f32, 0.1]));
            }
        }
        let shading = Shading::fit(&pixels).unwrap();
        let normal = DVec3::new(0.6, 0.0, -0.8);
        let at_peak = shading.logarithm(normal, &[0.46, 0.23, 0.1]);
        assert!(at_peak > shading.logarithm(normal, &[0.54, 0.27, 0.1]) + 1.0);
        assert!(at_peak > shading.logarithm(normal, &[0.38, 0.19, 0.1]) + 1.0);
        assert!(shading.spread < 1.1 * LEAST, "{}", shading.spread);
    }
}
