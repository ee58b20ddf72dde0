//! Where light that leaves a translucent surface may have entered it.
//!
//! King, Kulla, Conty, Fajardo 2013, "BSSRDF importance sampling": a distance and an angle are drawn on a disk about the
//! exit, and a probe ray through that point along the disk's axis meets the surface at the entries. Here all three axes of
//! the shading frame send a probe, by the same two numbers, and every entry found is weighed by the sum of the three
//! densities (the balance heuristic, Veach 1995): on a plane that is the profile's own, so that weights are free of noise.

use crate::basis::Basis;
use crate::bsdf::Profile;
use crate::bvh::Ray;
use crate::geometry::{Geometry, Surface};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Entries that are kept; those along the normal come first.
pub const MOST: usize = 8;
/// Surfaces that a probe passes at most: those of other objects count.
const PASSES: usize = 16;

/// A point where light may have entered.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// The point.
    pub surface: Surface,
    /// Its distance from the exit, metres.
    pub r: f32,
    /// 1 / its density per area.
    pub weight: f32,
}

/// The entries that one pair of numbers finds, on the same object as the exit.
pub fn entries(
    geometry: &Geometry,
    exit: &Surface,
    frame: &Basis,
    profile: &Profile,
    u: [f32; 2],
) -> [Option<Entry>; MOST] {
    let radius = profile.radius(u[0]);
    let (sin, cos) = libm::sincosf(TAU * u[1]);
    let shift = Vec2::new(radius * cos, radius * sin);
    let reach = profile.reach();
    let half = (reach * reach - radius * radius).max(0.0).sqrt();
    let mut found = [None; MOST];
    let mut count = 0;
    for [axis, x, y] in [[frame.z, frame.x, frame.y], [frame.x, frame.y, frame.z], [frame.y, frame.z, frame.x]] {
        let origin = exit.position + x * shift.x + y * shift.y - axis * half;
        let mut ray = Ray { origin, direction: axis, t_min: 0.0, t_max: 2.0 * half };
        for _ in 0..PASSES {
            if count == MOST {
                return found;
            }
            let Some(hit) = geometry.closest(&ray) else { break };
            ray.t_min = hit.t;
            if geometry.object_of(hit.triangle) != geometry.object_of(exit.triangle) {
                continue;
            }
            let surface = geometry.surface(&hit);
            let away = surface.position - exit.position;
            let density = density(frame, profile, away, surface.face);
            if density > 0.0 && density.is_finite() {
                found[count] = Some(Entry { surface, r: away.length(), weight: 1.0 / density });
                count += 1;
            }
        }
    }
    found
}

/// Density per area with which the three probes together find a point `away` from the exit.
fn density(frame: &Basis, profile: &Profile, away: Vec3, face: Vec3) -> f32 {
    let (d, f) = (frame.local(away), frame.local(face).abs());
    profile.pdf(Vec2::new(d.x, d.y).length()) * f.z
        + profile.pdf(Vec2::new(d.y, d.z).length()) * f.x
        + profile.pdf(Vec2::new(d.z, d.x).length()) * f.y
}
