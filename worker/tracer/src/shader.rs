//! A material made ready: its BSDF with tables, and where its derivatives go.

mod column;
mod effects;
#[cfg(test)]
mod tests;
mod translucent;

use crate::affine::rgb;
use crate::basis::Basis;
use crate::bsdf::{Bsdf, Conductor, Evaluation, Lambert, ParameterError, Plastic};
use crate::geometry::{Geometry, Surface};
use crate::planes::{self, PlaneIndex};
use effects::{Detail, Effects};
use glam::Vec3;
use gonio_scene::capture::{CAPTURE_FILE, Material, Model};
use gonio_scene::derivative::Plan;
use gonio_scene::{Result, SceneError};

/// The most derivative slots that a plain model has.
pub const MAX_SLOTS: usize = 8;

/// Index of refraction of air at standard conditions (Ciddor 1996, visible light): a capture's `ior` is against vacuum, as
/// tables give it, but light meets the part from air. That 0.03 % is 0.1 % of a plastic's diffuse light and of its
/// normal reflectance, which the reference renders show.
pub const AIR: f64 = 1.000_277;

/// A material's BSDF and the derivative planes of its slots.
#[derive(Clone, Debug)]
pub struct Shader {
    /// The reflectance of the plain model.
    bsdf: Bsdf,
    /// Plane of each of the BSDF's slots.
    planes: [PlaneIndex; MAX_SLOTS],
    /// What it has beyond the plain model, or is asked for.
    effects: Option<Box<Effects>>,
    /// Whether any derivative is wanted.
    pub freed: bool,
}

/// A point of a surface, ready to shade.
#[derive(Clone, Copy, Debug)]
pub struct Local {
    /// The shading frame; directions are given in it.
    pub basis: Basis,
    detail: Option<Detail>,
}

impl Shader {
    /// # Errors
    /// Parameters outside the model's domain.
    pub fn new(material: &Material, plan: &Plan) -> Result<Self> {
        let refuse = |e: ParameterError| {
            SceneError::new(CAPTURE_FILE, e.to_string(), "choose a value inside the model's domain")
                .at(format!("material.{}", material.name))
        };
        let bsdf = match &material.model {
            Model::Lambert { base_color } => Lambert::new(rgb(base_color)).map(Bsdf::Lambert),
            Model::Plastic { base_color, roughness, ior, energy_compensation } => {
                // d relative index / d ior = 1 / AIR is taken as 1: the difference is below the tables' own accuracy.
                let relative = (*ior / AIR) as f32;
                Plastic::new(rgb(base_color), *roughness as f32, relative, *energy_compensation).map(Bsdf::Plastic)
            }
            Model::Conductor { roughness, eta, k } => {
                Conductor::new(*roughness as f32, rgb(eta), rgb(k)).map(Bsdf::Conductor)
            }
        }
        .map_err(refuse)?;
        let effects = Effects::new(material, plan, AIR).map_err(refuse)?.map(Box::new);
        let mut slots = [None; MAX_SLOTS];
        if !effects.as_ref().is_some_and(|e| e.active) {
            for (plane, slot) in slots.iter_mut().zip(bsdf.slots()) {
                *plane = planes::find(plan, &format!("material.{}.{}", material.name, slot.name));
            }
        }
        let freed = slots.iter().any(Option::is_some) || effects.as_ref().is_some_and(|e| e.wanted());
        Ok(Self { bsdf, planes: slots, effects, freed })
    }

    /// The model, where there are loops for it and nothing beyond it.
    #[inline]
    pub fn many(&self) -> Option<&Bsdf> {
        (self.effects.is_none() && self.bsdf.has_many()).then_some(&self.bsdf)
    }

    /// The shading frame, and what else the material needs to know, at a point.
    #[inline]
    pub fn local(&self, surface: &Surface, geometry: &Geometry) -> Local {
        match &self.effects {
            None => Local { basis: Basis::new(surface.normal), detail: None },
            Some(effects) => {
                let (basis, detail) = effects.local(surface, geometry);
                Local { basis, detail: Some(detail) }
            }
        }
    }

    /// A flat sample of the material: the frame's x axis is the tangent, and no variation is known.
    pub fn flat(&self) -> Local {
        let detail = self.effects.is_some().then(Detail::flat);
        Local { basis: Basis { x: Vec3::X, y: Vec3::Y, z: Vec3::Z }, detail }
    }

    /// The effects and the point's details, where the plain model is not all.
    #[inline]
    fn active<'a>(&'a self, local: &'a Local) -> Option<(&'a Effects, &'a Detail)> {
        let effects = self.effects.as_ref().filter(|e| e.active)?;
        Some((effects, local.detail.as_ref()?))
    }

    /// As [`Bsdf::evaluate`].
    #[inline]
    pub fn evaluate(&self, local: &Local, wo: Vec3, wi: Vec3) -> Evaluation {
        match self.active(local) {
            None => self.bsdf.evaluate(wo, wi),
            Some((effects, detail)) => effects.evaluate(detail, wo, wi),
        }
    }

    /// As [`Bsdf::sample_direction`].
    #[inline]
    pub fn sample_direction(&self, local: &Local, wo: Vec3, u: [f32; 3]) -> Option<Vec3> {
        match self.active(local) {
            None => self.bsdf.sample_direction(wo, u),
            Some((effects, detail)) => effects.sample_direction(detail, wo, u),
        }
    }

    /// [`Self::evaluate`], with the derivatives that cost next to nothing beside it; [`Self::scatter`] takes the others.
    #[inline]
    pub fn evaluate_with_derivatives(
        &self,
        local: &Local,
        wo: Vec3,
        wi: Vec3,
        slots: &mut [Vec3; MAX_SLOTS],
    ) -> Evaluation {
        match self.active(local) {
            None => self.bsdf.evaluate_with_derivatives(wo, wi, slots),
            Some((effects, detail)) => effects.evaluate(detail, wo, wi),
        }
    }

    /// Adds `weight` times the derivative at fixed directions of each freed number to its plane. `slots` are those of
    /// [`Self::evaluate_with_derivatives`].
    #[inline]
    pub fn scatter(
        &self,
        local: &Local,
        wo: Vec3,
        wi: Vec3,
        slots: &[Vec3; MAX_SLOTS],
        weight: Vec3,
        into: &mut [Vec3],
    ) {
        for (plane, derivative) in self.planes.iter().zip(slots) {
            if let Some(plane) = plane {
                into[*plane] += weight * *derivative;
            }
        }
        if let (Some(effects), Some(detail)) = (&self.effects, &local.detail) {
            effects.scatter::<true>(detail, wo, wi, weight, into);
        }
    }
}
