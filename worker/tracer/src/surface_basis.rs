//! The basis in which a material varies over its object: products of cosines over the bounding box.
//!
//! `cos(pi i x) cos(pi j y) cos(pi k z)` with `1 <= i + j + k <= 6`, in order of their degree, then i, j, k descending. On
//! the box they are orthogonal and flat at its sides.

use glam::Vec3;
use gonio_scene::capture::VARIATIONS;
use std::f32::consts::PI;

/// The highest degree.
const DEGREE: usize = 6;

/// The powers (i, j, k) of each function.
const DEGREES: [[usize; 3]; VARIATIONS] = {
    let mut all = [[0; 3]; VARIATIONS];
    let (mut n, mut degree) = (0, 1);
    while degree <= DEGREE {
        let mut i = degree + 1;
        while i > 0 {
            i -= 1;
            let mut j = degree - i + 1;
            while j > 0 {
                j -= 1;
                all[n] = [i, j, degree - i - j];
                n += 1;
            }
        }
        degree += 1;
    }
    all
};

/// cos(pi i x) for each degree i along one axis, and its derivatives by x.
struct Axis {
    value: [f32; DEGREE + 1],
    slope: [f32; DEGREE + 1],
}

impl Axis {
    fn new(x: f32) -> Self {
        let (s, c) = libm::sincosf(PI * x);
        let (mut value, mut sine) = ([1.0; DEGREE + 1], [0.0; DEGREE + 1]);
        (value[1], sine[1]) = (c, s);
        // Chebyshev's recurrences.
        for i in 2..=DEGREE {
            value[i] = 2.0 * c * value[i - 1] - value[i - 2];
            sine[i] = 2.0 * c * sine[i - 1] - sine[i - 2];
        }
        let slope = std::array::from_fn(|i| -PI * i as f32 * sine[i]);
        Self { value, slope }
    }
}

/// The functions at a point of the unit box.
#[must_use]
pub fn values(p: Vec3) -> [f32; VARIATIONS] {
    let axes = p.to_array().map(Axis::new);
    DEGREES.map(|[i, j, k]| axes[0].value[i] * axes[1].value[j] * axes[2].value[k])
}

/// Their gradients at a point of the unit box.
#[must_use]
pub fn gradients(p: Vec3) -> [Vec3; VARIATIONS] {
    let [x, y, z] = p.to_array().map(Axis::new);
    DEGREES.map(|[i, j, k]| {
        let (u, v, w) = (x.value[i], y.value[j], z.value[k]);
        Vec3::new(x.slope[i] * v * w, u * y.slope[j] * w, u * v * z.slope[k])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_is_by_degree_then_descending() {
        let first = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 0, 0], [1, 1, 0], [1, 0, 1], [0, 2, 0], [0, 1, 1], [0, 0, 2]];
        assert_eq!(DEGREES[..9], first);
        assert_eq!((DEGREES[9], DEGREES[18], DEGREES[33]), ([3, 0, 0], [0, 0, 3], [0, 0, 4]));
        assert_eq!((DEGREES[54], DEGREES[55], DEGREES[82]), ([0, 0, 5], [6, 0, 0], [0, 0, 6]));
    }

    #[test]
    fn values_and_gradients_are_those_of_the_cosines() {
        let p = Vec3::new(0.2, 0.55, 0.9);
        let at = |p: Vec3| {
            let p = p.as_dvec3() * std::f64::consts::PI;
            DEGREES.map(|d| (0..3).map(|a| libm::cos(d[a] as f64 * p[a])).product::<f64>())
        };
        let (values, gradients) = (values(p), gradients(p));
        for (n, exact) in at(p).into_iter().enumerate() {
            assert!((f64::from(values[n]) - exact).abs() < 2e-6);
            for (axis, step) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
                let difference = (at(p + step * 1e-3)[n] - at(p - step * 1e-3)[n]) / 2e-3;
                assert!((f64::from(gradients[n][axis]) - difference).abs() < 2e-3, "{n} {axis}");
            }
        }
    }
}
