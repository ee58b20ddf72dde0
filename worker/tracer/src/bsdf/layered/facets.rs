//! The facets of a lobe that may be drawn out along a tangent.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::super::microfacet::{Ggx, HalfVector, Lobe};
use super::super::warp;

/// GGX facets, round or drawn out.
#[derive(Clone, Copy, Debug)]
pub enum Facets {
    /// The same in all azimuths.
    Round(Ggx),
    /// One alpha along the tangent, another across.
    Drawn(Drawn),
}

/// GGX facets of two widths (Heitz 2014, section 5.4).
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// Alpha along the tangent and across.
    alpha: Vec2,
    /// Cosine and sine of the tangent's azimuth in the shading frame.
    turn: Vec2,
}

impl Facets {
    /// The lobe's geometric value, and the density with which [`Self::sample_reflection`] draws `wi`.
    #[inline]
    pub fn lobe(&self, wo: Vec3, wi: Vec3, half: &HalfVector) -> Lobe {
        match self {
            Self::Round(ggx) => ggx.lobe(wo, wi, half),
            Self::Drawn(drawn) => drawn.lobe(wo, wi),
        }
    }

    /// Draws the mirror direction of `wo` in a visible facet; it may lie below the horizon.
    #[inline]
    pub fn sample_reflection(&self, wo: Vec3, u: Vec2) -> Vec3 {
        match self {
            Self::Round(ggx) => ggx.sample_reflection(wo, u),
            Self::Drawn(drawn) => drawn.sample_reflection(wo, u),
        }
    }
}

impl Drawn {
    /// Facets of `alpha` across the tangent and, by `KHR_materials_anisotropy`, `alpha + (1 - alpha) strength^2` along it.
    /// `turn` is the cosine and sine of the tangent's azimuth.
    pub fn new(alpha: f32, strength: f32, turn: Vec2) -> Self {
        Self { alpha: Vec2::new(alpha + (1.0 - alpha) * strength * strength, alpha), turn }
    }

    #[inline]
    fn lobe(&self, wo: Vec3, wi: Vec3) -> Lobe {
        let (wo, wi) = (self.local(wo), self.local(wi));
        let half = wo + wi;
        let length2 = half.length_squared();
        let slopes = half.truncate() / self.alpha;
        let stretched = slopes.length_squared() + half.z * half.z;
        let ratio = length2 / stretched;
        let density = ratio * ratio / (PI * self.alpha.x * self.alpha.y);
        let (mask_o, mask_i) = (self.stretch(wo).length(), self.stretch(wi).length());
        Lobe { value: density * wi.z / ((wo.z + mask_o) * (wi.z + mask_i)), pdf: 0.5 * density / (wo.z + mask_o) }
    }

    /// Spherical caps (Dupuy & Benyoub 2023), whole: the shorter cap of round facets holds for these with care only.
    #[inline]
    fn sample_reflection(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let wo = self.local(wo);
        let view = self.stretch(wo).normalize();
        let facet = self.stretch(view + warp::spherical_cap(u, -view.z));
        let wi = (2.0 * wo.dot(facet) / facet.length_squared()) * facet - wo;
        let (cos, sin) = (self.turn.x, self.turn.y);
        Vec3::new(cos * wi.x - sin * wi.y, sin * wi.x + cos * wi.y, wi.z)
    }

    #[inline]
    fn stretch(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.alpha.x * v.x, self.alpha.y * v.y, v.z)
    }

    #[inline]
    fn local(&self, v: Vec3) -> Vec3 {
        let (cos, sin) = (self.turn.x, self.turn.y);
        Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
    }
}
