//! A translucent surface in two parts: what is reflected where light arrives, and what enters, scatters and leaves elsewhere.
//!
//! The second part is the diffuse term of the surface with its factors shared out: the base's and the boundary's towards the
//! eye are those of the exit, the boundary's towards the light those of the entry. A [`Profile`] of the base's colour at the
//! exit stands between the two. Where entry and exit are one place, and in the limit of a short mean free path, both parts
//! add up to [`Layered::evaluate`].

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::super::{Evaluation, Profile, above_horizon, fresnel};
use super::recipe::{Core, Site};
use super::{Layered, mixture};

impl Layered {
    /// Mean free path below, metres; 0 where light leaves where it enters.
    #[inline]
    pub fn scatter_distance(&self) -> f32 {
        self.recipe.scatter_distance
    }

    /// The profile of light that leaves at a place, for a mean free path.
    #[inline]
    pub fn profile(&self, site: &Site, distance: f32) -> Profile {
        Profile::new((self.recipe.base_color * site.albedo).min(Vec3::ONE), distance)
    }

    /// As [`Layered::evaluate`], without the light from below; the density is that of the directions that
    /// [`Layered::sample_direction`] draws where [`Layered::goes_below`] says no.
    pub fn evaluate_above(&self, site: &Site, wo: Vec3, wi: Vec3) -> Evaluation {
        if !above_horizon(wo, wi) {
            return Evaluation::default();
        }
        self.at(site).evaluate::<false>(wo, wi)
    }

    /// Whether a path that arrives from `wo` goes below, by the number that chooses a lobe.
    pub fn goes_below(&self, site: &Site, wo: Vec3, choice: f32) -> bool {
        self.at(site).mixture(wo).pick(choice) == mixture::DIFFUSE
    }

    /// The chance of that.
    pub fn chance_below(&self, site: &Site, wo: Vec3) -> f32 {
        self.at(site).mixture(wo).chance(mixture::DIFFUSE)
    }

    /// Light from `wi` at the entry that leaves towards `wo` at the exit, `r` away: per steradian and area, times the cosine
    /// of `wi`. Each direction is in its own place's frame.
    pub fn below(&self, [exit, entry]: [&Site; 2], wo: Vec3, wi: Vec3, r: f32) -> Vec3 {
        if !above_horizon(wo, wi) {
            return Vec3::ZERO;
        }
        let (recipe, out, into) = (&self.recipe, self.at(exit), self.at(entry));
        let mut value = match (&recipe.core, &out.through, &into.through) {
            (Core::Plastic { .. }, Some(through), Some(back)) => {
                let mut value = through.base(out.color) * (through.transmittance(wo.z) * back.transmittance(wi.z));
                if let (Some(through), Some(back)) = (&out.through_second, &into.through_second) {
                    let second = through.base(out.color) * (through.transmittance(wo.z) * back.transmittance(wi.z));
                    value = value.lerp(second, recipe.second_lobe_weight);
                }
                value * (1.0 - out.metallic)
            }
            (Core::Conductor, ..) => return Vec3::ZERO,
            _ => out.color * FRAC_1_PI,
        };
        value *= wi.z * self.oren_nayar.map_or(1.0, |o| o.factor(wo, wi));
        if let Some(sheen) = &self.sheen {
            value *= Vec3::ONE - recipe.sheen_color * sheen.albedo(wo.z).max(sheen.albedo(wi.z));
        }
        if self.coat.is_some() {
            let pass = |cos: f32| 1.0 - recipe.clearcoat_factor * fresnel::dielectric(cos, recipe.clearcoat_ior);
            value *= pass(wo.z) * pass(wi.z);
        }
        value * Profile::new(out.color, recipe.scatter_distance).value(r)
    }
}
