//! Reflectance models: evaluation, sampling, and derivatives with respect to their parameters.
//!
//! Directions are unit vectors in the shading frame (z along the shading normal), both pointing away from the surface:
//! `wo` to where the light goes (the camera side of a path), `wi` to where it comes from. RGB triples are [`Vec3`].
//! Surfaces are one-sided: at or below the horizon nothing is reflected and nothing is sampled.
//!
//! | model | file | built from |
//! | --- | --- | --- |
//! | `lambert` | [`lambert`] | `warp` |
//! | `plastic` | [`plastic`] | `microfacet`, `fresnel`, `warp`; `boundary`, `reference`, `aliasing` and `table` once per material |
//! | `conductor` | [`conductor`] | `microfacet`, `fresnel` |
//!
//! [`layered`] stands over these three: what a surface has beyond them, at a place of it. It is no variant of [`Bsdf`], so
//! that plain surfaces run plain code.
//!
//! A new model is a file and a variant of [`Bsdf`]. Nothing here allocates after construction.

pub mod conductor;
pub mod lambert;
pub mod layered;
pub mod plastic;

mod aliasing;
mod boundary;
mod dual;
mod error;
mod exchange;
mod fresnel;
mod many;
mod microfacet;
mod profile;
mod quadrature;
mod reference;
mod table;
mod warp;

#[cfg(test)]
mod tests;

use glam::Vec3;

pub use conductor::Conductor;
pub use error::ParameterError;
pub use exchange::Exchange;
pub use lambert::Lambert;
pub use layered::{Built, Core, Layered, Recipe, Site, Spread};
pub use many::Evaluations;
pub use microfacet::ALPHA_FLOOR;
pub use plastic::Plastic;
pub use profile::Profile;

/// The reflectance of a surface.
#[derive(Clone, Debug)]
pub enum Bsdf {
    /// Ideal diffuse.
    Lambert(Lambert),
    /// A rough dielectric boundary over a diffuse base.
    Plastic(Plastic),
    /// A rough metal.
    Conductor(Conductor),
}

/// A BSDF at a pair of directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// BSDF times the cosine of `wi`, per steradian.
    pub value: Vec3,
    /// Density, per steradian, with which [`Bsdf::sample`] draws `wi`.
    pub pdf: f32,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The direction drawn, above the horizon.
    pub wi: Vec3,
    /// Its density per steradian, positive.
    pub pdf: f32,
    /// BSDF times the cosine of `wi`, per steradian.
    pub value: Vec3,
}

/// A parameter that derivatives are taken with respect to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// The capture format's key.
    pub name: &'static str,
    /// How the parameter acts on the colour channels.
    pub kind: SlotKind,
}

/// How a parameter acts on the colour channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotKind {
    /// Three parameters, each acting on its own channel: a derivative's channel `c` is `d value_c / d parameter_c`.
    Color,
    /// One number that acts on all channels.
    Scalar,
}

impl Slot {
    const fn color(name: &'static str) -> Self {
        Self { name, kind: SlotKind::Color }
    }

    const fn scalar(name: &'static str) -> Self {
        Self { name, kind: SlotKind::Scalar }
    }
}

impl Bsdf {
    /// Value and sampling density at a pair of directions; zero where either is not above the horizon.
    #[inline]
    pub fn evaluate(&self, wo: Vec3, wi: Vec3) -> Evaluation {
        if !above_horizon(wo, wi) {
            return Evaluation::default();
        }
        match self {
            Self::Lambert(model) => model.evaluate(wi),
            Self::Plastic(model) => model.evaluate(wo, wi),
            Self::Conductor(model) => model.evaluate(wo, wi),
        }
    }

    /// Draws `wi` about in proportion to the value: `u[0]` chooses the lobe, `u[1]` and `u[2]` the direction in it.
    ///
    /// All of `u` in `[0, 1)`. `None` where `wo` or the direction drawn is below the horizon; that has value zero, and
    /// counts as a sample.
    #[inline]
    pub fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<Sample> {
        let wi = self.sample_direction(wo, u)?;
        let Evaluation { value, pdf } = self.evaluate(wo, wi);
        (pdf > 0.0).then_some(Sample { wi, pdf, value })
    }

    /// [`Self::sample`] without the evaluation, for a caller that follows with [`Self::evaluate_with_derivatives`].
    #[inline]
    pub fn sample_direction(&self, wo: Vec3, u: [f32; 3]) -> Option<Vec3> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = match self {
            Self::Lambert(model) => model.sample_direction(u),
            Self::Plastic(model) => model.sample_direction(wo, u),
            Self::Conductor(model) => model.sample_direction(wo, u),
        };
        (wi.z > 0.0).then_some(wi)
    }

    /// The parameters of this model, in the order of [`Self::evaluate_with_derivatives`].
    pub fn slots(&self) -> &'static [Slot] {
        match self {
            Self::Lambert(_) => Lambert::SLOTS,
            Self::Plastic(_) => Plastic::SLOTS,
            Self::Conductor(_) => Conductor::SLOTS,
        }
    }

    /// [`Self::evaluate`], and the derivative of the value with respect to each slot with both directions held fixed.
    ///
    /// `derivatives` has room for [`Self::slots`]; the first so many are overwritten, the rest left alone. With too little
    /// room none is written.
    #[inline]
    pub fn evaluate_with_derivatives(&self, wo: Vec3, wi: Vec3, derivatives: &mut [Vec3]) -> Evaluation {
        debug_assert!(derivatives.len() >= self.slots().len(), "room for every slot");
        if !above_horizon(wo, wi) {
            derivatives.iter_mut().take(self.slots().len()).for_each(|d| *d = Vec3::ZERO);
            return Evaluation::default();
        }
        match (self, derivatives) {
            (Self::Lambert(model), [base_color, ..]) => model.evaluate_with_derivatives(wi, base_color),
            (Self::Plastic(model), [base_color, roughness, ior, ..]) => {
                model.evaluate_with_derivatives(wo, wi, [base_color, roughness, ior])
            }
            (Self::Conductor(model), [eta, k, roughness, ..]) => {
                model.evaluate_with_derivatives(wo, wi, [eta, k, roughness])
            }
            _ => self.evaluate(wo, wi),
        }
    }
}

#[inline]
fn above_horizon(wo: Vec3, wi: Vec3) -> bool {
    wo.z > 0.0 && wi.z > 0.0
}
