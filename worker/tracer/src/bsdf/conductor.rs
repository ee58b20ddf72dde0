//! A rough metal.

use glam::{Vec2, Vec3};

use super::error::{ParameterError, check, check_color};
use super::fresnel::ComplexIndex;
use super::microfacet::{Ggx, HalfVector};
use super::{Evaluation, Slot};

/// GGX microfacets of a conductor, with separable Smith shadowing: Mitsuba 3's `roughconductor`.
///
/// Light that would be reflected twice between facets is lost.
#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    ggx: Ggx,
    index: ComplexIndex,
}

impl Conductor {
    pub(super) const SLOTS: &'static [Slot] = &[Slot::color("eta"), Slot::color("k"), Slot::scalar("roughness")];

    /// A metal of perceptual `roughness` in `[0, 1]` and complex index `eta + i k` per channel.
    ///
    /// `eta` in `[0.001, 100]`, `k` in `[0, 100]`.
    ///
    /// # Errors
    /// A number that is not in its range.
    pub fn new(roughness: f32, eta: Vec3, k: Vec3) -> Result<Self, ParameterError> {
        Ok(Self {
            ggx: Ggx::new(check("roughness", roughness, 0.0, 1.0)?),
            index: ComplexIndex { eta: check_color("eta", eta, 1e-3, 100.0)?, k: check_color("k", k, 0.0, 100.0)? },
        })
    }

    #[inline]
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3) -> Evaluation {
        let half = HalfVector::new(wo, wi);
        let lobe = self.ggx.lobe(wo, wi, &half);
        Evaluation { value: lobe.value * self.index.reflectance(half.cos_d), pdf: lobe.pdf }
    }

    #[inline]
    pub(super) fn evaluate_with_derivatives(
        &self,
        wo: Vec3,
        wi: Vec3,
        [eta, k, roughness]: [&mut Vec3; 3],
    ) -> Evaluation {
        let half = HalfVector::new(wo, wi);
        let lobe = self.ggx.lobe(wo, wi, &half);
        let reflectance = self.index.reflectance_with_derivatives(half.cos_d);
        let value = lobe.value * reflectance.value;
        *eta = lobe.value * reflectance.d_eta;
        *k = lobe.value * reflectance.d_k;
        *roughness = value * (self.ggx.d_ln_lobe_d_alpha(wo, wi, &half) * self.ggx.d_alpha_d_roughness());
        Evaluation { value, pdf: lobe.pdf }
    }

    #[inline]
    pub(super) fn sample_direction(&self, wo: Vec3, [_, u, v]: [f32; 3]) -> Vec3 {
        self.ggx.sample_reflection(wo, Vec2::new(u, v))
    }
}
