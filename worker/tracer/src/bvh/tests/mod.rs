//! What the ray engine promises, against independent truths.

mod bits;
mod edges;
mod truth;

use super::{Bvh, Hit, Ray};
use glam::Vec3;

/// Scales of meshes, in their unit of length.
const SCALES: [f32; 7] = [1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6];

/// A reproducible sequence of numbers (Steele, Lea & Flood 2014, "SplitMix64").
struct Random(u64);

impl Random {
    /// Uniform in 0..1.
    fn number(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    /// Uniform in the cube from -1 to 1.
    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number()) * 2.0 - 1.0
    }

    /// Triangles of a tenth to the whole of the unit cube, scaled and moved.
    fn soup(&mut self, count: usize, scale: f32, offset: Vec3) -> Vec<[Vec3; 3]> {
        let triangle = |random: &mut Self| {
            let (centre, size) = (random.vector(), 0.1 + 0.9 * random.number().powi(4));
            [0; 3].map(|_| offset + scale * (centre + size * random.vector()))
        };
        (0..count).map(|_| triangle(self)).collect()
    }

    /// A ray through the unit cube, scaled and moved: from inside or outside, some parallel to an axis or a plane, of any
    /// length, some of them ending.
    fn ray(&mut self, scale: f32, offset: Vec3) -> Ray {
        let origin = offset + scale * self.vector() * if self.number() < 0.5 { 1.0 } else { 3.0 };
        let mut direction = (offset + scale * self.vector() - origin) / scale;
        for axis in 0..3 {
            if self.number() < 0.1 && direction.abs().max_element() > direction[axis].abs() {
                direction[axis] = if self.number() < 0.5 { 0.0 } else { -0.0 };
            }
        }
        direction *= [scale, 1.0, 1e-3][(self.number() * 3.0) as usize];
        let length = scale / direction.length();
        let t_min = if self.number() < 0.5 { 0.0 } else { self.number() * length };
        let t_max = if self.number() < 0.5 { f32::INFINITY } else { t_min + self.number() * 3.0 * length };
        Ray { origin, direction, t_min, t_max }
    }
}

/// A closed surface of `2 * around * (around - 1)` triangles: a sphere, dented by a wave.
fn dented_sphere(around: usize, scale: f32, offset: Vec3) -> Vec<[Vec3; 3]> {
    let vertex = |i: usize, j: usize| {
        // One vertex per pole and one seam, so that neighbours share their corners to the bit.
        let (sin_polar, cos_polar) = match i {
            0 => (0.0, 1.0),
            i if i == around => (0.0, -1.0),
            i => libm::sincosf(std::f32::consts::PI * i as f32 / around as f32),
        };
        let (sin, cos) = libm::sincosf(std::f32::consts::TAU * (j % around) as f32 / around as f32);
        let direction = Vec3::new(sin_polar * cos, sin_polar * sin, cos_polar);
        offset + scale * direction * (1.0 + 0.2 * direction.z * sin_polar * cos)
    };
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..around {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            if i + 1 < around {
                triangles.push([a, b, c]);
            }
            if i > 0 {
                triangles.push([a, c, d]);
            }
        }
    }
    triangles
}
