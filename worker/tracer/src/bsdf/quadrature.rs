//! Numerical integration rules, computed once per process.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

/// An integration rule with `N` nodes: the integral of `f` is about `sum weight * f(node)`.
pub struct Rule<const N: usize> {
    /// `(node, weight)` pairs.
    pub nodes: [(f64, f64); N],
}

impl<const N: usize> Rule<N> {
    /// The Gauss-Legendre rule on `[0, 1]`: exact for polynomials up to degree `2 N - 1`.
    ///
    /// Nodes are roots of the Legendre polynomial, found by Newton's method from Tricomi's estimate
    /// `cos(pi (i + 3/4) / (N + 1/2))`.
    pub fn gauss_legendre() -> Self {
        let mut nodes = [(0.0, 0.0); N];
        for (i, slot) in nodes.iter_mut().enumerate() {
            let mut x = -libm::cos(PI * (i as f64 + 0.75) / (N as f64 + 0.5));
            let mut slope = 1.0;
            // Newton doubles the digits each round; the estimate has four.
            for _ in 0..4 {
                let (value, derivative) = legendre(N, x);
                slope = derivative;
                x -= value / derivative;
            }
            *slot = (0.5 * (x + 1.0), 1.0 / ((1.0 - x * x) * slope * slope));
        }
        Self { nodes }
    }

    /// The Gauss-Legendre rule on `[0, 1]` with its nodes drawn towards 1 by `t -> 1 - (1 - t)^2`.
    ///
    /// For integrands that vary fast, or like a square root, at 1.
    pub fn drawn_to_one() -> Self {
        let mut rule = Self::gauss_legendre();
        for (node, weight) in &mut rule.nodes {
            let rest = 1.0 - *node;
            *weight *= 2.0 * rest;
            *node = 1.0 - rest * rest;
        }
        rule
    }

    /// The Gauss-Legendre rule on `[0, 1]` with its nodes drawn towards both ends by `t -> t^2 (3 - 2 t)`.
    pub fn drawn_to_both() -> Self {
        let mut rule = Self::gauss_legendre();
        for (node, weight) in &mut rule.nodes {
            let t = *node;
            *weight *= 6.0 * t * (1.0 - t);
            *node = t * t * (3.0 - 2.0 * t);
        }
        rule
    }

    /// The mean over a quarter circle: `(sin phi, weight)` at the midpoints of `N` equal arcs of `(0, pi / 2)`.
    ///
    /// For a smooth function of `sin^2 phi` it converges faster than any power of `N`.
    pub fn quarter_circle() -> Self {
        let mut nodes = [(0.0, 0.0); N];
        for (i, slot) in nodes.iter_mut().enumerate() {
            *slot = (libm::sin(FRAC_PI_2 * (i as f64 + 0.5) / N as f64), 1.0 / N as f64);
        }
        Self { nodes }
    }
}

/// Legendre polynomial of degree `n` and its derivative at `x`, by Bonnet's recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut current) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (previous, current) = (current, ((2.0 * k - 1.0) * x * current - (k - 1.0) * previous) / k);
    }
    (current, n as f64 * (x * current - previous) / (x * x - 1.0))
}

/// Sixteen Gauss-Legendre nodes.
pub static GAUSS: LazyLock<Rule<16>> = LazyLock::new(Rule::gauss_legendre);
/// Sixteen Gauss-Legendre nodes drawn towards 1.
pub static GAUSS_TO_ONE: LazyLock<Rule<16>> = LazyLock::new(Rule::drawn_to_one);
/// Sixteen Gauss-Legendre nodes drawn towards both ends.
pub static GAUSS_TO_BOTH: LazyLock<Rule<16>> = LazyLock::new(Rule::drawn_to_both);
/// Eight azimuths, which by symmetry stand for thirty-two.
pub static QUARTER_CIRCLE: LazyLock<Rule<8>> = LazyLock::new(Rule::quarter_circle);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_is_exact_for_polynomials() {
        for degree in 0..32 {
            let sum: f64 = GAUSS.nodes.iter().map(|(x, w)| w * x.powi(degree)).sum();
            assert!((sum - 1.0 / f64::from(degree + 1)).abs() < 1e-14, "degree {degree}: {sum}");
        }
    }

    #[test]
    fn drawn_nodes_integrate_a_square_root() {
        let sum: f64 = GAUSS_TO_ONE.nodes.iter().map(|(x, w)| w * (1.0 - x).sqrt()).sum();
        assert!((sum - 2.0 / 3.0).abs() < 1e-14, "{sum}");
    }

    #[test]
    fn nodes_drawn_to_both_ends_integrate_a_semicircle() {
        let sum: f64 = GAUSS_TO_BOTH.nodes.iter().map(|(x, w)| w * (x * (1.0 - x)).sqrt()).sum();
        assert!((sum - PI / 8.0).abs() < 1e-6, "{sum}");
    }

    #[test]
    fn quarter_circle_integrates_trigonometric_polynomials() {
        let sum: f64 = QUARTER_CIRCLE.nodes.iter().map(|(s, w)| w * s.powi(8)).sum();
        assert!((sum - 35.0 / 128.0).abs() < 1e-14, "{sum}");
    }
}
