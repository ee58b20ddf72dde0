//! Corners to a fraction of a pixel (Foerstner and Guelch 1987): every edge that meets in a corner points at it, so that
//! the gradient g at p is orthogonal to p - q for the corner q; q minimises the sum of (g (p - q))^2.

use nalgebra::{Matrix2, Vector2};

/// A gray image, row by row.
pub(super) struct Gray<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) data: &'a [u8],
}

impl Gray<'_> {
    /// Bilinear between pixels, whose centres are whole numbers; the border goes on outwards.
    pub(super) fn at(&self, x: f64, y: f64) -> f64 {
        let x = x.clamp(0.0, self.width as f64 - 1.0);
        let y = y.clamp(0.0, self.height as f64 - 1.0);
        let (i, j) = (x.floor() as usize, y.floor() as usize);
        let (u, v) = (x - i as f64, y - j as f64);
        let (i1, j1) = ((i + 1).min(self.width - 1), (j + 1).min(self.height - 1));
        let pixel = |i: usize, j: usize| f64::from(self.data[j * self.width + i]);
        (pixel(i, j) * (1.0 - u) + pixel(i1, j) * u) * (1.0 - v) + (pixel(i, j1) * (1.0 - u) + pixel(i1, j1) * u) * v
    }

    /// The corner near `start`, from a window of `reach` pixels to either side; `start` where there is none within it.
    /// Pixel centres are whole numbers.
    pub(super) fn refine(&self, start: [f64; 2], reach: i32) -> [f64; 2] {
        let mut corner = Vector2::from(start);
        for _ in 0..30 {
            let (mut a, mut b) = (Matrix2::zeros(), Vector2::zeros());
            for j in -reach..=reach {
                for i in -reach..=reach {
                    let offset = Vector2::new(f64::from(i), f64::from(j));
                    let p = corner + offset;
                    let g = Vector2::new(
                        self.at(p.x + 1.0, p.y) - self.at(p.x - 1.0, p.y),
                        self.at(p.x, p.y + 1.0) - self.at(p.x, p.y - 1.0),
                    );
                    let weight = libm::exp(-offset.norm_squared() / f64::from(reach * reach));
                    let product = g * g.transpose() * weight;
                    a += product;
                    b += product * offset;
                }
            }
            let Some(inverse) = a.try_inverse() else { return start };
            let step = inverse * b;
            corner += step;
            if !step.iter().all(|x| x.is_finite()) || (corner - Vector2::from(start)).amax() > f64::from(reach) {
                return start;
            }
            if step.norm() < 1e-3 {
                break;
            }
        }
        corner.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_between_squares_is_found() {
        // Smooth edges through (20.3, 19.6), turned and sheared.
        let truth = [20.3, 19.6];
        let edge = |d: f64| libm::tanh(d / 0.8);
        let value = |i: usize, j: usize| {
            let (x, y) = (i as f64 - truth[0], j as f64 - truth[1]);
            (128.0 + 100.0 * edge(0.95 * x + 0.2 * y) * edge(-0.3 * x + 0.9 * y)) as u8
        };
        let data: Vec<u8> = (0..40).flat_map(|j| (0..40).map(move |i| value(i, j))).collect();
        let gray = Gray { width: 40, height: 40, data: &data };
        let [x, y] = gray.refine([21.5, 18.8], 5);
        assert!((x - truth[0]).abs() < 0.05 && (y - truth[1]).abs() < 0.05, "{x} {y}");
        let flat = Gray { width: 40, height: 40, data: &[9; 1600] };
        assert_eq!(flat.refine([5.0, 6.0], 5), [5.0, 6.0]);
    }
}
