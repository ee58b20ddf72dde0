//! A rough dielectric boundary over a diffuse base.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use super::boundary::RoughBoundary;
use super::dual::Dual;
use super::error::{ParameterError, check, check_color};
use super::microfacet::{Ggx, HalfVector, Lobe};
use super::table::AngularTable;
use super::{Evaluation, Slot, fresnel, reference, warp};

/// Least chance of either lobe, so that a lobe of weight zero, whose derivative may not be zero, is still sampled.
const LEAST_LOBE_PROBABILITY: f32 = 0.1;

/// GGX microfacets over a Lambertian base: Mitsuba 3's `roughplastic` with `nonlinear`.
///
/// The value is `F D G / (4 cos_o cos_i)` plus `T(o) T(i) base_color / (pi ior^2 (1 - base_color F_in))`, with `T` the
/// boundary's transmittance and `F_in` the mean reflectance that the base sees, both here as the reference renderer takes
/// them (see `reference::transmittances`, `RoughBoundary::mean_reflectance_inside_as_reference`).
///
/// Without energy compensation both count one scattering at the boundary, as the reference renderer does, and what would
/// scatter again is lost: a white base under a white sky shows 0.74 at alpha 0.25 and index 1.5.
///
/// With energy compensation `T' = 1 - R`, where `R` is what this very specular lobe reflects, and by reciprocity
/// `F_in' = 1 - mean(T') / ior^2`: everything that the lobe does not reflect enters the base, and a white base returns
/// it, so that the white furnace is `R + T' = 1` by construction. Kulla & Conty (2017, "Revisiting physically based
/// shading at Imageworks") give the light of further bounces between facets a lobe of its own, not tinted by the base;
/// here it takes the base's colour, which needs no third lobe and differs little, a dielectric reflecting some 5 % at
/// each bounce.
#[derive(Clone, Debug)]
pub struct Plastic {
    ggx: Ggx,
    ior: f32,
    transmittance: AngularTable,
    base: Base,
    /// Mean over the channels of the diffuse albedo divided by `T(o)`, for the choice of lobe.
    base_weight: f32,
}

/// The diffuse term's factor `base_color / (pi ior^2 (1 - base_color F_in))` and its derivatives.
#[derive(Clone, Copy, Debug)]
struct Base {
    value: Vec3,
    d_color: Vec3,
    d_alpha: Vec3,
    d_ior: Vec3,
}

impl Plastic {
    pub(super) const SLOTS: &'static [Slot] =
        &[Slot::color("base_color"), Slot::scalar("roughness"), Slot::scalar("ior")];

    /// Builds the tables of one material, which takes about a millisecond.
    ///
    /// `base_color` and perceptual `roughness` in `[0, 1]`, `ior` in `[1.001, 10]`.
    ///
    /// # Errors
    /// A number that is not in its range.
    pub fn new(base_color: Vec3, roughness: f32, ior: f32, energy_compensation: bool) -> Result<Self, ParameterError> {
        let base_color = check_color("base_color", base_color, 0.0, 1.0)?;
        let ggx = Ggx::new(check("roughness", roughness, 0.0, 1.0)?);
        let ior = check("ior", ior, 1.001, 10.0)?;

        let index = Dual::ior(f64::from(ior));
        let Tables { transmittance, internal, mean_transmittance } = tables(ggx.alpha(), ior, energy_compensation);
        let base = Base::new(base_color, index, internal);
        let base_weight = base.value.element_sum() / 3.0 / FRAC_1_PI * mean_transmittance.value as f32;
        Ok(Self { ggx, ior, transmittance, base, base_weight })
    }

    #[inline]
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3) -> Evaluation {
        self.evaluate_through(wo, wi, self.through(wo.z), self.through(wi.z))
    }

    /// The boundary's transmittance at a cosine.
    #[inline]
    pub(super) fn through(&self, cos: f32) -> f32 {
        self.transmittance.value(cos)
    }

    /// [`Self::evaluate`] where the transmittances at both cosines are known.
    #[inline(always)]
    pub(super) fn evaluate_through(&self, wo: Vec3, wi: Vec3, through_o: f32, through_i: f32) -> Evaluation {
        let half = HalfVector::new(wo, wi);
        let lobe = self.ggx.lobe(wo, wi, &half);
        let specular = lobe.value * fresnel::dielectric(half.cos_d, self.ior);
        Evaluation {
            value: self.base.value * (through_o * through_i * wi.z) + specular,
            pdf: self.pdf(&lobe, through_o, wi),
        }
    }

    #[inline]
    pub(super) fn evaluate_with_derivatives(
        &self,
        wo: Vec3,
        wi: Vec3,
        [base_color, roughness, ior]: [&mut Vec3; 3],
    ) -> Evaluation {
        let half = HalfVector::new(wo, wi);
        let lobe = self.ggx.lobe(wo, wi, &half);
        let [through_o, d_alpha_o, d_ior_o] = self.transmittance.value_and_derivatives(wo.z);
        let [through_i, d_alpha_i, d_ior_i] = self.transmittance.value_and_derivatives(wi.z);
        let (reflectance, d_reflectance) = fresnel::dielectric_with_derivative(half.cos_d, self.ior);

        let specular = lobe.value * reflectance;
        let through = through_o * through_i * wi.z;
        let d_alpha_through = (d_alpha_o * through_i + through_o * d_alpha_i) * wi.z;
        let d_ior_through = (d_ior_o * through_i + through_o * d_ior_i) * wi.z;

        *base_color = self.base.d_color * through;
        let d_alpha = self.base.d_alpha * through
            + self.base.value * d_alpha_through
            + specular * self.ggx.d_ln_lobe_d_alpha(wo, wi, &half);
        *roughness = d_alpha * self.ggx.d_alpha_d_roughness();
        *ior = self.base.d_ior * through + self.base.value * d_ior_through + lobe.value * d_reflectance;
        Evaluation { value: self.base.value * through + specular, pdf: self.pdf(&lobe, through_o, wi) }
    }

    #[inline]
    pub(super) fn sample_direction(&self, wo: Vec3, [choice, u, v]: [f32; 3]) -> Vec3 {
        let u = Vec2::new(u, v);
        if choice < self.specular_probability(self.through(wo.z)) {
            self.ggx.sample_reflection(wo, u)
        } else {
            warp::cosine_hemisphere(u)
        }
    }

    /// [`Self::sample_direction`] where the transmittance is known, without a branch.
    #[inline(always)]
    pub(super) fn sample_through(&self, wo: Vec3, [choice, u, v]: [f32; 3], through_o: f32) -> Vec3 {
        let u = Vec2::new(u, v);
        let (mirrored, scattered) = (self.ggx.sample_reflection(wo, u), warp::cosine_hemisphere(u));
        let mirror = choice < self.specular_probability(through_o);
        let pick = |a: f32, b: f32| if mirror { a } else { b };
        Vec3::new(pick(mirrored.x, scattered.x), pick(mirrored.y, scattered.y), pick(mirrored.z, scattered.z))
    }

    #[inline(always)]
    fn pdf(&self, lobe: &Lobe, through_o: f32, wi: Vec3) -> f32 {
        let specular = self.specular_probability(through_o);
        specular * lobe.pdf + (1.0 - specular) * warp::cosine_hemisphere_pdf(wi.z)
    }

    /// Chance of sampling the specular lobe: its share of the light reflected towards `wo`.
    #[inline(always)]
    fn specular_probability(&self, through_o: f32) -> f32 {
        let specular = 1.0 - through_o;
        let diffuse = through_o * self.base_weight;
        (specular / (specular + diffuse)).clamp(LEAST_LOBE_PROBABILITY, 1.0 - LEAST_LOBE_PROBABILITY)
    }
}

/// What a boundary's roughness and index of refraction determine.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    /// By the cosine outside.
    pub(super) transmittance: AngularTable,
    /// The mean reflectance that the base sees.
    pub(super) internal: Dual,
    /// Cosine-weighted mean of the transmittance.
    pub(super) mean_transmittance: Dual,
}

/// The tables of a boundary of GGX `alpha` over a medium of relative index `ior`: see [`Plastic`].
pub(super) fn tables(alpha: f32, ior: f32, energy_compensation: bool) -> Tables {
    let (alpha, index) = (f64::from(alpha), Dual::ior(f64::from(ior)));
    let boundary = RoughBoundary::new(alpha, index.value);
    let mean_transmittance = -boundary.mean_reflectance_outside() + 1.0;
    let (transmittance, internal) = if energy_compensation {
        let transmittance = AngularTable::smooth(|cos| -boundary.reflectance(cos) + 1.0);
        (transmittance, -(mean_transmittance / index.square()) + 1.0)
    } else {
        let transmittance = AngularTable::linear(&reference::transmittances(alpha, index.value));
        (transmittance, boundary.mean_reflectance_inside_as_reference())
    };
    Tables { transmittance, internal, mean_transmittance }
}

impl Base {
    fn new(color: Vec3, ior: Dual, internal: Dual) -> Self {
        let channel = |color: f32| {
            let color = f64::from(color);
            let scale = Dual::constant(f64::from(FRAC_1_PI)) / (ior.square() * (-(internal * color) + 1.0));
            let d_color = scale.value / (1.0 - color * internal.value);
            [scale.value * color, d_color, scale.d_alpha * color, scale.d_ior * color].map(|x| x as f32)
        };
        let [r, g, b] = color.to_array().map(channel);
        let [value, d_color, d_alpha, d_ior] = std::array::from_fn(|i| Vec3::new(r[i], g[i], b[i]));
        Self { value, d_color, d_alpha, d_ior }
    }
}
