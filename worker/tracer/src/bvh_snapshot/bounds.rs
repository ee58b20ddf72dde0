//! Axis-aligned boxes that hold a triangle however the arithmetic of the intersection test rounds.

use glam::Vec3;

/// How far, relative to itself, a box interval may be off the triangle test that it stands for. The rounding errors of
/// both add up to about 10 * 2^-24.
pub(super) const SLACK: f32 = 1.0 / (1 << 20) as f32;

/// A box, lower and upper corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub low: Vec3,
    pub high: Vec3,
}

impl Bounds {
    pub const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// The box of a triangle, widened by what a ray that starts between the triangle's vertices may round away.
    pub fn padded(triangle: &[Vec3; 3]) -> Self {
        let [a, b, c] = *triangle;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let pad = (high - low).element_sum() * SLACK;
        // One step further, so that the box is no thinner than a float where the padding vanishes beside the corner.
        let step = |corner: Vec3, f: fn(f32) -> f32| Vec3::from_array(corner.to_array().map(f));
        Self { low: step(low - pad, f32::next_down), high: step(high + pad, f32::next_up) }
    }

    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub fn half_area(&self) -> f32 {
        let size = (self.high - self.low).max(Vec3::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}
