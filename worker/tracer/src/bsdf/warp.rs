//! Maps from uniform random numbers to directions.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4};

use glam::{Vec2, Vec3};

/// Sine and cosine of an angle of at most pi/4 either way, to 1e-7: Taylor's series. No branch and no call, so that loops
/// over it vectorise.
#[inline(always)]
fn sincos(x: f32) -> (f32, f32) {
    let y = x * x;
    let sin = x + x * y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * (-1.0 / 5040.0 + y * (1.0 / 362_880.0))));
    let cos =
        1.0 + y * (-0.5 + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y * (1.0 / 40_320.0 + y * (-1.0 / 3_628_800.0)))));
    (sin, cos)
}

/// Sine and cosine of a share of a full turn, in `[0, 1]`.
#[inline(always)]
pub fn sincos_of_turn(turn: f32) -> (f32, f32) {
    let quarters = 4.0 * turn;
    let nearest = (quarters + 0.5) as i32;
    let (sin, cos) = sincos(FRAC_PI_2 * (quarters - nearest as f32));
    let (s, c) = if nearest & 1 == 0 { (sin, cos) } else { (cos, sin) };
    (if nearest & 2 == 0 { s } else { -s }, if (nearest + 1) & 2 == 0 { c } else { -c })
}

/// Uniform square to uniform unit disk, keeping neighbours together (Shirley & Chiu 1997).
#[inline(always)]
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let (x, y) = (2.0 * u.x - 1.0, 2.0 * u.y - 1.0);
    let wide = x.abs() > y.abs();
    let (long, short) = if wide { (x, y) } else { (y, x) };
    let (sin, cos) = sincos(FRAC_PI_4 * (short / if long == 0.0 { 1.0 } else { long }));
    if wide { Vec2::new(long * cos, long * sin) } else { Vec2::new(long * sin, long * cos) }
}

/// Uniform square to a direction about +z with density [`cosine_hemisphere_pdf`].
#[inline(always)]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let p = concentric_disk(u);
    p.extend((1.0 - p.length_squared()).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`] per solid angle, at a cosine of at least 0.
#[inline(always)]
pub fn cosine_hemisphere_pdf(cos: f32) -> f32 {
    cos * FRAC_1_PI
}

/// Uniform square to the spherical cap `z >= bottom` of the unit sphere.
#[inline(always)]
pub fn spherical_cap(u: Vec2, bottom: f32) -> Vec3 {
    let (sin, cos) = sincos_of_turn(u.x);
    // 1 - z without its cancellation near the pole.
    let drop = u.y * (1.0 - bottom);
    let radius = (drop * (2.0 - drop)).max(0.0).sqrt();
    Vec3::new(radius * cos, radius * sin, 1.0 - drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_those_of_the_library() {
        for i in 0..=100_000 {
            let turn = i as f32 / 100_000.0;
            let (sin, cos) = sincos_of_turn(turn);
            let (exact_sin, exact_cos) = libm::sincos(std::f64::consts::TAU * f64::from(turn));
            assert!((f64::from(sin) - exact_sin).abs() < 2e-7 && (f64::from(cos) - exact_cos).abs() < 2e-7, "{turn}");
        }
    }
}
