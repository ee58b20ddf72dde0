//! Isotropic GGX microfacets with separable Smith shadowing and masking.
//!
//! Walter et al. 2007, "Microfacet models for refraction through rough surfaces"; Heitz 2014, "Understanding the
//! masking-shadowing function in microfacet-based BRDFs".

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::warp;

/// Least GGX alpha: the half width, in radians, of the highlight that roughness 0 shows.
///
/// A smaller one is narrower than a pixel from any sane distance and, in `f32`, all rounding error.
pub const ALPHA_FLOOR: f32 = 1e-3;

/// A GGX distribution of facet normals.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    alpha: f32,
    alpha2: f32,
    d_alpha_d_roughness: f32,
}

/// The reflection geometry of a pair of directions, both above the horizon.
#[derive(Clone, Copy, Debug)]
pub struct HalfVector {
    /// Cosine between either direction and the half vector.
    pub cos_d: f32,
    /// Squared cosine between the half vector and the shading normal.
    cos2_h: f32,
    /// Squared sine of the same angle, from the components so that small angles keep their digits.
    pub sin2_h: f32,
}

impl HalfVector {
    /// The geometry of `wo`, `wi`, unit vectors with positive z.
    #[inline(always)]
    pub fn new(wo: Vec3, wi: Vec3) -> Self {
        let sum = wo + wi;
        let length2 = sum.length_squared();
        let inverse = 1.0 / length2;
        Self {
            cos_d: (0.5 * length2.sqrt()).min(1.0),
            cos2_h: sum.z * sum.z * inverse,
            sin2_h: (sum.x * sum.x + sum.y * sum.y) * inverse,
        }
    }
}

/// `D G1(o) G1(i) / (4 cos_o cos_i)` times `cos_i`: the value of a lobe but for its Fresnel reflectance.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// Per steradian.
    pub value: f32,
    /// Density of [`Ggx::sample_reflection`] per solid angle.
    pub pdf: f32,
}

impl Ggx {
    /// The distribution of perceptual `roughness` in `[0, 1]`: alpha is its square, at least [`ALPHA_FLOOR`].
    pub fn new(roughness: f32) -> Self {
        let square = roughness * roughness;
        let alpha = square.max(ALPHA_FLOOR);
        let d_alpha_d_roughness = if square >= ALPHA_FLOOR { 2.0 * roughness } else { 0.0 };
        Self { alpha, alpha2: alpha * alpha, d_alpha_d_roughness }
    }

    /// The roughness parameter alpha.
    pub fn alpha(&self) -> f32 {
        self.alpha
    }

    /// Derivative of alpha with respect to the roughness given; zero on the floor.
    pub fn d_alpha_d_roughness(&self) -> f32 {
        self.d_alpha_d_roughness
    }

    /// The lobe's geometric value, and the density with which [`Self::sample_reflection`] draws `wi`.
    #[inline(always)]
    pub fn lobe(&self, wo: Vec3, wi: Vec3, half: &HalfVector) -> Lobe {
        let density = self.density(half);
        let (mask_o, mask_i) = (self.stretched_length(wo.z), self.stretched_length(wi.z));
        Lobe {
            value: density * wi.z / ((wo.z + mask_o) * (wi.z + mask_i)),
            pdf: 0.5 * density / (self.cap_scale(wo) * wo.z + mask_o),
        }
    }

    /// Derivative of the logarithm of [`Lobe::value`] with respect to alpha.
    #[inline]
    pub fn d_ln_lobe_d_alpha(&self, wo: Vec3, wi: Vec3, half: &HalfVector) -> f32 {
        let distribution =
            2.0 / self.alpha - 4.0 * self.alpha * half.cos2_h / (half.sin2_h + self.alpha2 * half.cos2_h);
        let masking = |cos: f32| {
            let length = self.stretched_length(cos);
            self.alpha * (1.0 - cos * cos) / (length * (cos + length))
        };
        distribution - masking(wo.z) - masking(wi.z)
    }

    /// Draws the mirror direction of `wo` in a visible facet; it may lie below the horizon.
    ///
    /// Spherical caps (Dupuy & Benyoub 2023) with the cap cut where no reflection can rise above the horizon
    /// (Eto & Tokuyoshi 2023, "Bounded VNDF sampling for Smith-GGX reflections").
    #[inline(always)]
    pub fn sample_reflection(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let stretched = Vec3::new(self.alpha * wo.x, self.alpha * wo.y, wo.z);
        let view = stretched * (1.0 / self.stretched_length(wo.z));
        let normal = view + warp::spherical_cap(u, -self.cap_scale(wo) * view.z);
        let facet = Vec3::new(self.alpha * normal.x, self.alpha * normal.y, normal.z);
        (2.0 * wo.dot(facet) / facet.length_squared()) * facet - wo
    }

    /// Density of facet normals per solid angle.
    #[inline(always)]
    fn density(&self, half: &HalfVector) -> f32 {
        let spread = half.sin2_h + self.alpha2 * half.cos2_h;
        self.alpha2 / (PI * spread * spread)
    }

    /// Length of a direction of this cosine after stretching its tangent by alpha: `G1 = 2 cos / (cos + length)`.
    #[inline(always)]
    fn stretched_length(&self, cos: f32) -> f32 {
        let cos2 = cos * cos;
        (cos2 + self.alpha2 * (1.0 - cos2).max(0.0)).sqrt()
    }

    /// The factor by which bounded sampling shortens the cap, for alpha at most 1 (Eto & Tokuyoshi 2023, eq. 5).
    #[inline(always)]
    fn cap_scale(&self, wo: Vec3) -> f32 {
        let s = 1.0 + (wo.x * wo.x + wo.y * wo.y).sqrt();
        let s2 = s * s;
        (1.0 - self.alpha2) * s2 / (s2 + self.alpha2 * wo.z * wo.z)
    }
}
