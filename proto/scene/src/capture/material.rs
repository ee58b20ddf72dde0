//! Materials: what a surface reflects.

use super::effects::Effects;
use super::maps::Maps;
use super::visit::{Range, Section, Visitor, colour};
use crate::Result;

/// A named material.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name that objects and dotted parameter names use.
    pub name: String,
    /// How it reflects.
    pub model: Model,
    /// What it has beyond the plain model.
    pub effects: Effects,
    /// How its numbers vary over a mesh.
    pub maps: Maps,
}

/// The reflectance models of the capture format.
#[derive(Debug, Clone, PartialEq)]
pub enum Model {
    /// Reflects base_color / pi in every direction.
    Lambert {
        /// Linear RGB reflectance, 0 to 1.
        base_color: [f64; 3],
    },
    /// A rough dielectric boundary (GGX) over a Lambertian base.
    Plastic {
        /// Linear RGB reflectance of the base, 0 to 1.
        base_color: [f64; 3],
        /// Perceptual roughness, GGX alpha = roughness squared.
        roughness: f64,
        /// Real index of refraction.
        ior: f64,
        /// Whether light that would scatter twice between facets is given back.
        energy_compensation: bool,
    },
    /// A rough metal (GGX) with a complex index of refraction.
    Conductor {
        /// Perceptual roughness, GGX alpha = roughness squared.
        roughness: f64,
        /// Real part of the index per channel.
        eta: [f64; 3],
        /// Imaginary part of the index per channel.
        k: [f64; 3],
    },
}

impl Model {
    /// The word that `model = "..."` uses.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Lambert { .. } => "lambert",
            Self::Plastic { .. } => "plastic",
            Self::Conductor { .. } => "conductor",
        }
    }

    fn blank(word: &str) -> Option<Self> {
        let gray = [0.5; 3];
        match word {
            "lambert" => Some(Self::Lambert { base_color: gray }),
            "plastic" => Some(Self::Plastic { base_color: gray, roughness: 0.5, ior: 1.5, energy_compensation: false }),
            "conductor" => Some(Self::Conductor { roughness: 0.5, eta: [1.0; 3], k: [1.0; 3] }),
            _ => None,
        }
    }
}

impl Default for Material {
    fn default() -> Self {
        let model = Model::Lambert { base_color: [0.5; 3] };
        Self { name: String::new(), model, effects: Effects::default(), maps: Maps::default() }
    }
}

impl Section for Material {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        v.text("name", &mut self.name, None)?;
        let mut word = self.model.word().to_owned();
        v.text("model", &mut word, None)?;
        if word != self.model.word() {
            self.model = Model::blank(&word).ok_or_else(|| {
                v.refuse("model", format!("is \"{word}\""), "write one of: lambert, plastic, conductor")
            })?;
        }
        match &mut self.model {
            Model::Lambert { base_color } => colour(v, "base_color", base_color, Range::UNIT, None)?,
            Model::Plastic { base_color, roughness, ior, energy_compensation } => {
                colour(v, "base_color", base_color, Range::UNIT, None)?;
                v.number("roughness", roughness, Range::UNIT, None)?;
                v.number("ior", ior, Range::IOR, None)?;
                v.flag("energy_compensation", energy_compensation, false)?;
            }
            Model::Conductor { roughness, eta, k } => {
                v.number("roughness", roughness, Range::UNIT, None)?;
                colour(v, "eta", eta, Range { min: 0.0, max: 100.0 }, None)?;
                colour(v, "k", k, Range { min: 0.0, max: 100.0 }, None)?;
            }
        }
        self.maps.describe(&self.model, v)?;
        self.effects.describe(&self.model, v)
    }
}
