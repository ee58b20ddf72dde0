//! Gradients: for each pixel the orientation of the strongest among the colours, where it stands out of the noise.

use image::Rgb32FImage;
use std::f64::consts::PI;

/// Orientations that are told apart, over half a turn: an edge from dark to bright is one from bright to dark.
pub(crate) const BINS: usize = 8;

/// A gradient this many times the low quantile of them all is an edge's; on a Rayleigh distribution one in 10^4 is, by chance.
const OVER_NOISE: f32 = 4.5;

/// The quantile that stands for the noise: less than half of an image has to be without edges.
const QUIET: f32 = 0.3;

/// Least gradient of an edge, in values (0 to 1) a pixel: a step of 8 bits over a pixel.
const LEAST: f32 = 0.008;

/// A vector for each pixel.
pub(crate) struct Gradients {
    pub width: usize,
    /// Change of the value a pixel, along columns and rows; row by row.
    pub vectors: Vec<[f32; 2]>,
}

impl Gradients {
    /// By Sobel's filter; 0 along the border.
    pub fn of(image: &Rgb32FImage) -> Self {
        let (width, height) = (image.width() as usize, image.height() as usize);
        let raw = image.as_raw().as_slice();
        let mut vectors = vec![[0.0; 2]; width * height];
        for row in 1..height.saturating_sub(1) {
            let [above, here, below] =
                [row - 1, row, row + 1].map(|r| raw.get(3 * r * width..3 * (r + 1) * width).unwrap_or(&[]));
            let out = vectors.get_mut(row * width..(row + 1) * width).unwrap_or(&mut []);
            for (column, vector) in out.iter_mut().enumerate().take(width.saturating_sub(1)).skip(1) {
                let mut strongest = 0.0;
                for channel in 0..3 {
                    let (l, m, r) = (3 * (column - 1) + channel, 3 * column + channel, 3 * (column + 1) + channel);
                    let gx = (above[r] - above[l] + 2.0 * (here[r] - here[l]) + below[r] - below[l]) / 8.0;
                    let gy = (below[l] - above[l] + 2.0 * (below[m] - above[m]) + below[r] - above[r]) / 8.0;
                    let squared = gx * gx + gy * gy;
                    if squared > strongest {
                        strongest = squared;
                        *vector = [gx, gy];
                    }
                }
            }
        }
        Self { width, vectors }
    }

    /// For each pixel the bit of its bin, or none where the gradient does not stand out.
    pub fn bits(&self) -> Vec<u8> {
        let mut squares: Vec<f32> = self.vectors.iter().map(|[x, y]| x * x + y * y).collect();
        let all = squares.clone();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
        let rank = (squares.len() as f32 * QUIET) as usize;
        let quiet = if squares.is_empty() {
            0.0
        } else {
            *squares.select_nth_unstable_by(rank.min(all.len() - 1), f32::total_cmp).1
        };
        let least = (OVER_NOISE * OVER_NOISE * quiet).max(LEAST * LEAST);
        let bit = |(vector, square): (&[f32; 2], &f32)| {
            if *square < least { 0 } else { 1 << bin(f64::from(vector[0]), f64::from(vector[1])) }
        };
        self.vectors.iter().zip(&all).map(bit).collect()
    }
}

/// The bin of a gradient's orientation.
pub(crate) fn bin(x: f64, y: f64) -> usize {
    let turn = libm::atan2(y, x) / PI;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // 0 to 8
    let index = (turn.rem_euclid(1.0) * BINS as f64).round() as usize;
    index % BINS
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageBuffer, Rgb};

    #[test]
    fn an_edge_has_the_orientation_of_its_normal_whatever_its_sign() {
        for (turn, expected) in [(0.0, 0), (45.0, 2), (90.0, 4), (135.0, 6), (180.0, 0), (225.0, 2)] {
            let (sine, cosine) = libm::sincos(f64::to_radians(turn));
            let image = ImageBuffer::from_fn(40, 40, |x, y| {
                let side = (f64::from(x) - 20.2) * cosine + (f64::from(y) - 20.3) * sine;
                let value = if side > 0.0 { 0.8 } else { 0.2 };
                Rgb([0.5, value, 0.5])
            });
            let bits = Gradients::of(&image).bits();
            assert_eq!(bits[20 * 40 + 20], 1 << expected, "{turn}");
            assert_eq!(bits[5 * 40 + 5] & bits[35 * 40 + 5] & bits[35 * 40 + 35], 0);
        }
    }

    #[test]
    fn noise_has_hardly_an_edge() {
        let mut state = 1u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from((state >> 40) as u32) / f64::from(1 << 24) - 0.5
        };
        let image = ImageBuffer::from_fn(200, 200, |_, _| Rgb([0; 3].map(|_: i32| 0.5 + 0.2 * noise() as f32)));
        let edges = Gradients::of(&image).bits().iter().filter(|bits| **bits != 0).count();
        assert!(edges < 400, "{edges} of 40000");
    }
}
