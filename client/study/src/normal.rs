//! The normal distribution and Student's t, by statrs.

use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::function::erf::{erfc, erfc_inv};
use std::f64::consts::{PI, SQRT_2};

/// Density of the standard normal distribution.
pub(crate) fn density(x: f64) -> f64 {
    libm::exp(-0.5 * x * x) / (2.0 * PI).sqrt()
}

/// Its distribution function.
pub(crate) fn below(x: f64) -> f64 {
    0.5 * erfc(-x / SQRT_2)
}

/// Its quantile, the z of detection theory, for 0 < p < 1.
pub(crate) fn z(p: f64) -> f64 {
    -SQRT_2 * erfc_inv(2.0 * p)
}

/// The quantile of Student's t for a two-sided interval of 95 %.
pub(crate) fn t95(freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}
