//! The square maps of pbrt-v4: the sphere by equal areas, as an octahedron unfolded (Clarberg 2008, "Fast equal-area mapping of
//! the (hemi)sphere using SIMD").

use crate::sky;
use gonio_scene::image::Image;
use std::f64::consts::PI;

/// Directions that are averaged along each side of a pixel.
const INSIDE: u32 = 4;

/// The unit direction at (u, v) of the unit square: pbrt's `EqualAreaSquareToSphere`.
pub fn direction(u: f64, v: f64) -> [f64; 3] {
    let (u, v) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let (across, down) = (u.abs(), v.abs());
    // Positive in the middle diamond, which is the upper half.
    let depth = 1.0 - (across + down);
    let radius = 1.0 - depth.abs();
    let phi = if radius == 0.0 { PI / 4.0 } else { ((down - across) / radius + 1.0) * PI / 4.0 };
    let z = (1.0 - radius * radius).copysign(depth);
    let side = radius * (2.0 - radius * radius).max(0.0).sqrt();
    [libm::cos(phi).copysign(u) * side, libm::sin(phi).copysign(v) * side, z]
}

/// An equirectangular map as a square one, with about as many pixels.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub fn square(map: &Image) -> Image {
    let pixels = f64::from(map.width) * f64::from(map.height);
    let side = (pixels.sqrt().ceil() as u32).clamp(1, gonio_scene::MAX_SIDE);
    let mut square = Image { width: side, height: side, pixels: Vec::new() };
    let place =
        |pixel: u32, part: u32| (f64::from(pixel) + (f64::from(part) + 0.5) / f64::from(INSIDE)) / f64::from(side);
    for y in 0..side {
        for x in 0..side {
            let mut sum = [0.0; 3];
            for part in 0..INSIDE * INSIDE {
                let towards = direction(place(x, part % INSIDE), place(y, part / INSIDE));
                sum.iter_mut().zip(sky::radiance(map, towards)).for_each(|(sum, r)| *sum += r);
            }
            square.pixels.push(sum.map(|s| (s / f64::from(INSIDE * INSIDE)) as f32));
        }
    }
    square
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_covers_the_sphere_evenly() {
        assert!((direction(0.5, 0.5)[2] - 1.0).abs() < 1e-12, "the middle is up");
        assert!((direction(0.0, 0.0)[2] + 1.0).abs() < 1e-12, "the corners are down");
        assert!((direction(1.0, 0.5)[0] - 1.0).abs() < 1e-12, "the right edge's middle is x");
        let n = 64;
        let (mut mean, mut square) = ([0.0; 3], [0.0; 3]);
        for i in 0..n * n {
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
            let d = direction(at(i % n), at(i / n));
            assert!((d.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
            for k in 0..3 {
                mean[k] += d[k] / f64::from(n * n);
                square[k] += d[k] * d[k] / f64::from(n * n);
            }
        }
        assert!(mean.iter().all(|m| m.abs() < 1e-9), "{mean:?}");
        assert!(square.iter().all(|s| (s - 1.0 / 3.0).abs() < 1e-3), "{square:?}");
    }

    #[test]
    fn an_even_map_stays_even() {
        let map = Image { width: 8, height: 4, pixels: vec![[1.0, 2.0, 3.0]; 32] };
        let square = square(&map);
        assert_eq!((square.width, square.height), (6, 6));
        assert!(square.pixels.iter().all(|p| *p == [1.0, 2.0, 3.0]));
    }
}
