//! A surface with what plain models leave out: rough bases, second lobes, metal, drawn-out highlights, sheen, coats, and
//! parameters that vary over the surface.
//!
//! | layer | file |
//! | --- | --- |
//! | the numbers | [`recipe`] |
//! | diffuse factor of rough bases | `oren_nayar` |
//! | the boundary of a plastic, by place | `boundary` |
//! | light that enters at one place and leaves at another | [`below`] |
//! | round and drawn-out facets | `facets` |
//! | fibres over the rest | `sheen` |
//! | which lobe is sampled how often | `mixture` |

pub mod below;
mod boundary;
mod facets;
mod mixture;
mod oren_nayar;
pub mod recipe;
mod sheen;

use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use self::boundary::{Ladder, Through};
use self::facets::{Drawn, Facets};
use self::mixture::{LOBES, Mixture};
use self::oren_nayar::OrenNayar;
use self::sheen::Sheen;
use super::error::{ParameterError, check, check_color};
use super::fresnel::{self, ComplexIndex};
use super::microfacet::{Ggx, HalfVector};
use super::{Evaluation, above_horizon, warp};

pub use boundary::Built;
pub use recipe::{Core, Recipe, Site, Spread};

/// A layered surface, its tables built.
///
/// From below: `(1 - metallic)` of one plastic or a blend of two, and `metallic` of a metal; the sheen takes from that what
/// it reflects, the coat from all below. Conductors and lambertian surfaces stand in place of the blend.
#[derive(Clone, Debug)]
pub struct Layered {
    recipe: Recipe,
    oren_nayar: Option<OrenNayar>,
    /// Of the first and the second plastic; the second where it has weight.
    boundaries: Option<(Ladder, Option<Ladder>)>,
    second: Ggx,
    coat: Option<Ggx>,
    sheen: Option<Arc<Sheen>>,
    index: ComplexIndex,
}

/// A surface at one place.
struct Place<'a> {
    surface: &'a Layered,
    color: Vec3,
    metallic: f32,
    first: Facets,
    second: Facets,
    through: Option<Through<'a>>,
    through_second: Option<Through<'a>>,
}

impl Layered {
    /// Builds the tables; those of boundaries that `built` has are shared.
    ///
    /// # Errors
    /// A number outside the range of the capture format.
    pub fn new(recipe: Recipe, built: &mut Built) -> Result<Self, ParameterError> {
        let unit = |name, value| check(name, value, 0.0, 1.0);
        let positive = |name, color| check_color(name, color, 0.0, 1.0);
        positive("base_color", recipe.base_color)?;
        positive("sheen_color", recipe.sheen_color)?;
        unit("roughness", recipe.roughness)?;
        unit("second_lobe_roughness", recipe.second_lobe_roughness)?;
        unit("clearcoat_roughness", recipe.clearcoat_roughness)?;
        unit("sheen_roughness", recipe.sheen_roughness)?;
        unit("anisotropy_strength", recipe.anisotropy_strength)?;
        check("diffuse_roughness", recipe.diffuse_roughness, 0.0, 2.1)?;
        check("ior", recipe.ior, 1.001, 10.0)?;
        check("clearcoat_ior", recipe.clearcoat_ior, 1.001, 10.0)?;
        if recipe.core == Core::Conductor {
            check_color("eta", recipe.eta, 1e-3, 101.0)?;
            check_color("k", recipe.k, 0.0, 101.0)?;
        }
        let boundaries = if let Core::Plastic { energy_compensation } = recipe.core {
            let spread = recipe.roughness_spread;
            let first = Ladder::new(recipe.roughness, spread, recipe.ior, energy_compensation, built);
            let second = (recipe.second_lobe_weight != 0.0)
                .then(|| Ladder::new(recipe.second_lobe_roughness, None, recipe.ior, energy_compensation, built));
            Some((first, second))
        } else {
            None
        };
        Ok(Self {
            recipe,
            oren_nayar: (recipe.diffuse_roughness > 0.0).then(|| OrenNayar::new(recipe.diffuse_roughness)),
            boundaries,
            second: Ggx::new(recipe.second_lobe_roughness),
            coat: (recipe.clearcoat_factor != 0.0).then(|| Ggx::new(recipe.clearcoat_roughness)),
            sheen: (recipe.sheen_color != Vec3::ZERO).then(|| Arc::new(Sheen::new(recipe.sheen_roughness))),
            index: ComplexIndex { eta: recipe.eta, k: recipe.k },
        })
    }

    /// The numbers it was built of.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// As `Bsdf::evaluate`, at a place.
    pub fn evaluate(&self, site: &Site, wo: Vec3, wi: Vec3) -> Evaluation {
        if !above_horizon(wo, wi) {
            return Evaluation::default();
        }
        self.at(site).evaluate::<true>(wo, wi)
    }

    /// As `Bsdf::sample_direction`, at a place.
    pub fn sample_direction(&self, site: &Site, wo: Vec3, [choice, u, v]: [f32; 3]) -> Option<Vec3> {
        if wo.z <= 0.0 {
            return None;
        }
        let place = self.at(site);
        let u = Vec2::new(u, v);
        let wi = match place.mixture(wo).pick(choice) {
            mixture::FIRST => place.first.sample_reflection(wo, u),
            mixture::SECOND => place.second.sample_reflection(wo, u),
            mixture::COAT => self.coat?.sample_reflection(wo, u),
            mixture::SHEEN => warp::spherical_cap(u, 0.0),
            _ => warp::cosine_hemisphere(u),
        };
        (wi.z > 0.0).then_some(wi)
    }

    fn at(&self, site: &Site) -> Place<'_> {
        let recipe = &self.recipe;
        let roughness = (recipe.roughness * site.roughness).min(1.0);
        let facets = |ggx: Ggx| {
            if recipe.anisotropy_strength == 0.0 {
                return Facets::Round(ggx);
            }
            // cross(axis, z), turned by the rotation.
            let tangent = Vec2::new(site.axis.y, -site.axis.x).normalize_or(Vec2::X);
            let (sin, cos) = libm::sincosf(recipe.anisotropy_rotation);
            let turn = Vec2::new(tangent.x * cos - tangent.y * sin, tangent.x * sin + tangent.y * cos);
            Facets::Drawn(Drawn::new(ggx.alpha(), recipe.anisotropy_strength, turn))
        };
        Place {
            surface: self,
            color: (recipe.base_color * site.albedo).min(Vec3::ONE),
            metallic: recipe.metallic * site.metallic,
            first: facets(Ggx::new(roughness)),
            second: facets(self.second),
            through: self.boundaries.as_ref().and_then(|b| b.0.at(roughness)),
            through_second: self.boundaries.as_ref().and_then(|b| b.1.as_ref()?.at(recipe.second_lobe_roughness)),
        }
    }
}

/// Schlick's reflectance of a metal (1994).
#[inline]
fn schlick(normal: Vec3, cos: f32) -> Vec3 {
    let rest = (1.0 - cos).max(0.0);
    let square = rest * rest;
    normal + (Vec3::ONE - normal) * (square * square * rest)
}

impl Place<'_> {
    /// The whole surface, or what of it is not `DIFFUSE`.
    fn evaluate<const DIFFUSE: bool>(&self, wo: Vec3, wi: Vec3) -> Evaluation {
        let recipe = &self.surface.recipe;
        let half = HalfVector::new(wo, wi);
        let mut densities = [0.0; LOBES];
        if DIFFUSE {
            densities[mixture::DIFFUSE] = warp::cosine_hemisphere_pdf(wi.z);
        }
        let rough = self.surface.oren_nayar.map_or(1.0, |o| o.factor(wo, wi));
        let first = self.first.lobe(wo, wi, &half);
        densities[mixture::FIRST] = first.pdf;
        let mut value = match (&recipe.core, &self.through) {
            (Core::Plastic { .. }, Some(through)) => {
                let reflectance = fresnel::dielectric(half.cos_d, recipe.ior);
                let diffuse = |t: &Through<'_>| {
                    if !DIFFUSE {
                        return Vec3::ZERO;
                    }
                    t.base(self.color) * (t.transmittance(wo.z) * t.transmittance(wi.z) * wi.z * rough)
                };
                let mut plastic = diffuse(through) + first.value * reflectance;
                if let Some(other) = &self.through_second {
                    let second = self.second.lobe(wo, wi, &half);
                    densities[mixture::SECOND] = second.pdf;
                    let weight = recipe.second_lobe_weight;
                    plastic = plastic * (1.0 - weight) + (diffuse(other) + second.value * reflectance) * weight;
                }
                let metal = schlick(self.color, half.cos_d) * first.value;
                plastic * (1.0 - self.metallic) + metal * self.metallic
            }
            (Core::Conductor, _) => first.value * self.surface.index.reflectance(half.cos_d),
            _ if DIFFUSE => self.color * (FRAC_1_PI * wi.z * rough),
            _ => Vec3::ZERO,
        };
        if let Some(sheen) = &self.surface.sheen {
            let taken = sheen.albedo(wo.z).max(sheen.albedo(wi.z));
            let color = recipe.sheen_color;
            value = value * (Vec3::ONE - color * taken) + color * sheen.value(wo, wi, &half);
            densities[mixture::SHEEN] = 0.5 * FRAC_1_PI;
        }
        if let Some(coat) = &self.surface.coat {
            let (factor, ior) = (recipe.clearcoat_factor, recipe.clearcoat_ior);
            let lobe = coat.lobe(wo, wi, &half);
            let pass = |cos: f32| 1.0 - factor * fresnel::dielectric(cos, ior);
            value = value * (pass(wo.z) * pass(wi.z)) + factor * lobe.value * fresnel::dielectric(half.cos_d, ior);
            densities[mixture::COAT] = lobe.pdf;
        }
        Evaluation { value, pdf: self.mixture(wo).density(&densities) }
    }

    /// Each lobe's share of the light reflected towards `wo`, about.
    fn mixture(&self, wo: Vec3) -> Mixture {
        let recipe = &self.surface.recipe;
        let mut shares = [None; LOBES];
        match (&recipe.core, &self.through) {
            (Core::Plastic { .. }, Some(through)) => {
                let (metal, weight) = (self.metallic, recipe.second_lobe_weight);
                let share = |t: &Through<'_>, weight: f32| {
                    let passed = t.transmittance(wo.z);
                    let part = weight * (1.0 - metal);
                    ((1.0 - passed) * part, passed * t.base_weight(t.base(self.color)) * part)
                };
                let (mut specular, mut diffuse) = share(through, 1.0 - weight);
                if let Some(other) = &self.through_second {
                    let second = share(other, weight);
                    shares[mixture::SECOND] = Some(second.0);
                    diffuse += second.1;
                }
                specular += metal * schlick(self.color, wo.z).element_sum() / 3.0;
                shares[mixture::FIRST] = Some(specular);
                shares[mixture::DIFFUSE] = Some(diffuse);
            }
            (Core::Conductor, _) => shares[mixture::FIRST] = Some(1.0),
            _ => shares[mixture::DIFFUSE] = Some(self.color.element_sum() / 3.0),
        }
        if let Some(sheen) = &self.surface.sheen {
            shares[mixture::SHEEN] = Some(sheen.albedo(wo.z) * recipe.sheen_color.element_sum() / 3.0);
        }
        if self.surface.coat.is_some() {
            let reflected = recipe.clearcoat_factor * fresnel::dielectric(wo.z, recipe.clearcoat_ior);
            shares.iter_mut().flatten().for_each(|s| *s *= 1.0 - reflected);
            shares[mixture::COAT] = Some(reflected);
        }
        Mixture::new(shares)
    }
}
