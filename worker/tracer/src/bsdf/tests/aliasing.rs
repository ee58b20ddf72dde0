//! The reference renderer's rule for the mean internal reflectance, evaluated in full.

use std::f64::consts::FRAC_PI_4;

use super::super::boundary::RoughBoundary;
use super::super::quadrature::Rule;

/// `(x, y, weight)` on the unit disk: 128 x 128 Gauss-Legendre nodes by the concentric map.
fn disk() -> Vec<(f64, f64, f64)> {
    let rule = Rule::<128>::gauss_legendre();
    let mut points = Vec::new();
    for &(u, u_weight) in &rule.nodes {
        for &(v, v_weight) in &rule.nodes {
            let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            let swap = a.abs() < b.abs();
            let (radius, other) = if swap { (b, a) } else { (a, b) };
            let angle = FRAC_PI_4 * other / radius;
            let (near, far) = (radius * libm::cos(angle), radius * libm::sin(angle));
            let (x, y) = if swap { (far, near) } else { (near, far) };
            points.push((x, y, u_weight * v_weight));
        }
    }
    points
}

/// `mean of 2 cos R(cos)` over cosines `0, 1/63, ... 1` from inside, with each facet's normal in slopes.
fn rule(points: &[(f64, f64, f64)], alpha: f64, ior: f64) -> f64 {
    let mut mean = 0.0;
    for i in 0..64 {
        let cos = (f64::from(i) / 63.0).max(1e-6);
        let sin = (1.0 - cos * cos).sqrt();
        let length = (alpha * alpha * sin * sin + cos * cos).sqrt();
        let (up, along) = (cos / length, alpha * sin / length);
        let mut reflectance = 0.0;
        for &(x, y, weight) in points {
            let s = 0.5 * (1.0 + up);
            let y = (1.0 - s) * (1.0 - x * x).sqrt() + s * y;
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            let scale = alpha / (along * y + up * z);
            let (slope_x, slope_y) = ((up * y - along * z) * scale, x * scale);
            let cos_h = 1.0 / (1.0 + slope_x * slope_x + slope_y * slope_y).sqrt();
            let cos_d = (cos - sin * slope_x) * cos_h;
            let above = 2.0 * cos_d * cos_h - cos;
            if above <= 0.0 {
                continue;
            }
            let tan2 = (1.0 - above * above) / (above * above);
            let smith = 2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt());
            let cos2_t = 1.0 - (1.0 - cos_d * cos_d) * ior * ior;
            let cos_t = cos2_t.max(0.0).sqrt();
            let s = (ior * cos_d - cos_t) / (ior * cos_d + cos_t);
            let p = (ior * cos_t - cos_d) / (ior * cos_t + cos_d);
            reflectance += weight * smith * 0.5 * (s * s + p * p);
        }
        mean += 2.0 * cos * reflectance / 64.0;
    }
    mean
}

/// Mitsuba's own values, from its `eval` for three base colours, are 0.557355, 0.715508 and 0.061714.
#[test]
fn rule_is_that_of_mitsuba() {
    let points = disk();
    for (alpha, ior, value) in [(0.09, 1.5, 0.557_355), (0.04, 1.8, 0.715_508), (1.0, 1.3, 0.061_714)] {
        let mean = rule(&points, alpha, ior);
        assert!((mean - value).abs() < 2e-6, "alpha {alpha} ior {ior}: {mean}, Mitsuba {value}");
    }
}

/// Over three rows of nodes in steps that meet every phase of the saw tooth, then coarsely up to alpha 1.
///
/// The rule's mean over cosines has a kink at the critical angle that only roughness blurs: below alpha 0.02 it shows.
#[test]
fn mean_reflectance_as_reference() {
    let points = disk();
    let fine = (0..27).map(|i| 0.03 + 0.0028 * f64::from(i));
    for alpha in fine.chain([0.13, 0.16, 0.2, 0.25, 0.3, 0.36, 0.42, 0.5, 0.7, 1.0]) {
        for ior in [1.3, 1.5, 1.8] {
            let mean = rule(&points, alpha, ior);
            let value = RoughBoundary::new(alpha, ior).mean_reflectance_inside_as_reference().value;
            assert!((value - mean).abs() < 1.2e-4, "alpha {alpha} ior {ior}: {value}, the rule {mean}");
        }
    }
}
