//! Boxes that hold a triangle however the arithmetic of the hit test rounds.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;

/// How far, relative to itself, a box interval may be off the triangle test that it stands for: 32 rounding errors of
/// single precision, where the two together make about ten.
pub(super) const SLACK: f32 = 1.0 / (1 << 19) as f32;

/// Rays enter boxes up to this factor beyond their limit, so that a box lets every hit of the triangle test through.
pub(super) const BOX_SLACK: f32 = 1.0 + 4.0 * SLACK;

/// The box of a triangle, widened by what a ray that starts between the planes of two vertices may round away, and by
/// one float more, so that it has a thickness even where that vanishes beside the coordinates.
pub(super) fn padded(&[a, b, c]: &[Vec3; 3]) -> Aabb {
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let pad = (high - low).element_sum() * SLACK;
    let step = |corner: Vec3, next: fn(f32) -> f32| Vec3A::new(next(corner.x), next(corner.y), next(corner.z));
    Aabb::new(step(low - pad, f32::next_down), step(high + pad, f32::next_up))
}
