//! Maps from uniform random numbers to directions.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, TAU};

use glam::{Vec2, Vec3};

/// Uniform square to uniform unit disk, keeping neighbours together (Shirley & Chiu 1997).
#[inline]
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let p = 2.0 * u - Vec2::ONE;
    if p.x == 0.0 && p.y == 0.0 {
        return Vec2::ZERO;
    }
    if p.x.abs() > p.y.abs() {
        let (sin, cos) = libm::sincosf(FRAC_PI_4 * (p.y / p.x));
        p.x * Vec2::new(cos, sin)
    } else {
        let (sin, cos) = libm::sincosf(FRAC_PI_4 * (p.x / p.y));
        p.y * Vec2::new(sin, cos)
    }
}

/// Uniform square to a direction about +z with density [`cosine_hemisphere_pdf`].
#[inline]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let p = concentric_disk(u);
    p.extend((1.0 - p.length_squared()).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`] per solid angle, at a cosine of at least 0.
#[inline]
pub fn cosine_hemisphere_pdf(cos: f32) -> f32 {
    cos * FRAC_1_PI
}

/// Uniform square to the spherical cap `z >= bottom` of the unit sphere.
#[inline]
pub fn spherical_cap(u: Vec2, bottom: f32) -> Vec3 {
    let (sin, cos) = libm::sincosf(TAU * u.x);
    // 1 - z without its cancellation near the pole.
    let drop = u.y * (1.0 - bottom);
    let radius = (drop * (2.0 - drop)).max(0.0).sqrt();
    Vec3::new(radius * cos, radius * sin, 1.0 - drop)
}
