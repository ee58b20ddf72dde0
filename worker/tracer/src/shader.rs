//! A material made ready: its BSDF with tables, and where its derivatives go.

use crate::affine::rgb;
use crate::bsdf::{Bsdf, Conductor, Lambert, Plastic};
use crate::planes::{self, PlaneIndex};
use glam::Vec3;
use gonio_scene::capture::{CAPTURE_FILE, Material, Model};
use gonio_scene::derivative::Plan;
use gonio_scene::{Result, SceneError};

/// The most derivative slots that a model has.
pub const MAX_SLOTS: usize = 8;

/// Index of refraction of air at standard conditions (Ciddor 1996, visible light): a capture's `ior` is against vacuum, as
/// tables give it, but light meets the part from air. That 0.03 % is 0.1 % of a plastic's diffuse light and of its
/// normal reflectance, which the reference renders show.
const AIR: f64 = 1.000_277;

/// A material's BSDF and the derivative planes of its slots.
#[derive(Clone, Debug)]
pub struct Shader {
    /// The reflectance.
    pub bsdf: Bsdf,
    /// Plane of each of the BSDF's slots.
    pub planes: [PlaneIndex; MAX_SLOTS],
    /// Whether any slot has a plane.
    pub freed: bool,
}

impl Shader {
    /// # Errors
    /// Parameters outside the model's domain.
    pub fn new(material: &Material, plan: &Plan) -> Result<Self> {
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
        .map_err(|e| {
            SceneError::new(CAPTURE_FILE, e.to_string(), "choose a value inside the model's domain")
                .at(format!("material.{}", material.name))
        })?;
        let mut slots = [None; MAX_SLOTS];
        for (plane, slot) in slots.iter_mut().zip(bsdf.slots()) {
            *plane = planes::find(plan, &format!("material.{}.{}", material.name, slot.name));
        }
        Ok(Self { bsdf, planes: slots, freed: slots.iter().any(Option::is_some) })
    }

    /// Adds `weight` times the derivative of each freed slot to its plane.
    #[inline]
    pub fn scatter(&self, derivatives: &[Vec3; MAX_SLOTS], weight: Vec3, into: &mut [Vec3]) {
        for (plane, derivative) in self.planes.iter().zip(derivatives) {
            if let Some(plane) = plane {
                into[*plane] += weight * *derivative;
            }
        }
    }
}
