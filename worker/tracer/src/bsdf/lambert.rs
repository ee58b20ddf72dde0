//! The ideal diffuse surface.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use super::error::{ParameterError, check_color};
use super::{Evaluation, Slot, warp};

/// Reflects `base_color / pi` in every direction.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    base_color: Vec3,
}

impl Lambert {
    pub(super) const SLOTS: &'static [Slot] = &[Slot::color("base_color")];

    /// A surface of reflectance `base_color`, each channel in `[0, 1]`.
    ///
    /// # Errors
    /// A channel that is not in that range.
    pub fn new(base_color: Vec3) -> Result<Self, ParameterError> {
        Ok(Self { base_color: check_color("base_color", base_color, 0.0, 1.0)? })
    }

    #[inline(always)]
    pub(super) fn evaluate(&self, wi: Vec3) -> Evaluation {
        Evaluation { value: self.base_color * (FRAC_1_PI * wi.z), pdf: warp::cosine_hemisphere_pdf(wi.z) }
    }

    #[inline]
    pub(super) fn evaluate_with_derivatives(&self, wi: Vec3, base_color: &mut Vec3) -> Evaluation {
        *base_color = Vec3::splat(FRAC_1_PI * wi.z);
        self.evaluate(wi)
    }

    #[inline(always)]
    pub(super) fn sample_direction(&self, [_, u, v]: [f32; 3]) -> Vec3 {
        warp::cosine_hemisphere(Vec2::new(u, v))
    }
}
