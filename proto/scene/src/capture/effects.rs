//! What real surfaces have beyond a plain model, each nothing at its null value: second lobes, coats, variation.

use super::material::Model;
use super::visit::{Numbers, Range, Visitor, colour};
use crate::Result;

/// Products of cosines over an object's bounding box that vary its colour, roughness and height: all of degree 1 to 6.
pub const VARIATIONS: usize = 83;

/// The dotted suffixes of a variation's numbers.
pub const VARIATION: [&str; VARIATIONS] = [
    "0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12", "13", "14", "15", "16", "17", "18", "19", "20",
    "21", "22", "23", "24", "25", "26", "27", "28", "29", "30", "31", "32", "33", "34", "35", "36", "37", "38", "39",
    "40", "41", "42", "43", "44", "45", "46", "47", "48", "49", "50", "51", "52", "53", "54", "55", "56", "57", "58",
    "59", "60", "61", "62", "63", "64", "65", "66", "67", "68", "69", "70", "71", "72", "73", "74", "75", "76", "77",
    "78", "79", "80", "81", "82",
];

/// The step of the derivative by a number that acts through its square, at the number's null value.
///
/// `diffuse_roughness` and `anisotropy_strength` have no slope at 0. There, and only there, their derivative image holds
/// `(radiance(NULL_STEP) - radiance(0)) / NULL_STEP`; divided by `NULL_STEP` once more it is the slope by the square.
pub const NULL_STEP: f64 = 0.1;

/// Longest mean free path below a surface, metres: beyond, a part is no longer a surface to light.
pub const LONGEST_SCATTER: f64 = 0.1;

/// The effects of a material. Which of them a model has, [`Effects::describe`] says.
#[derive(Debug, Clone, PartialEq)]
pub struct Effects {
    /// Oren and Nayar's spread of facet slopes, radians, 0..=2: a factor on the diffuse term.
    pub diffuse_roughness: f64,
    /// Share of a second plastic that differs in roughness alone, 0..=1.
    pub second_lobe_weight: f64,
    /// Its perceptual roughness, 0..=1.
    pub second_lobe_roughness: f64,
    /// Coverage by a clear coat, 0..=1.
    pub clearcoat_factor: f64,
    /// Perceptual roughness of the coat, 0..=1.
    pub clearcoat_roughness: f64,
    /// Index of refraction of the coat, against vacuum.
    pub clearcoat_ior: f64,
    /// Share of a metal that reflects `base_color` along its normal, 0..=1.
    pub metallic: f64,
    /// Mean free path of light below the surface, metres, 0..=0.1 (`scatterDistance` of the glTF draft
    /// `KHR_materials_subsurface`): the diffuse light that enters at a point leaves at distance r with density
    /// `(exp(-r/d) + exp(-r/(3d))) / (8 pi d r)` per area, `d = scatter_distance / (1.9 - A + 3.5 (A - 0.8)^2)`, A the
    /// channel's `base_color` (Christensen and Burley 2015). At 0 it leaves where it enters.
    pub scatter_distance: f64,
    /// How far the highlight is drawn out along the tangent, 0..=1.
    pub anisotropy_strength: f64,
    /// Turn of the tangent about the normal, radians.
    pub anisotropy_rotation: f64,
    /// Linear RGB reflectance of fibres at grazing angles, 0..=1.
    pub sheen_color: [f64; 3],
    /// Perceptual roughness of the sheen, 0..=1.
    pub sheen_roughness: f64,
    /// `base_color` times the exponential of this sum of [`VARIATIONS`] basis functions.
    pub albedo_variation: [f64; VARIATIONS],
    /// `roughness` times the exponential of this sum.
    pub roughness_variation: [f64; VARIATIONS],
    /// Height over the surface, in diagonals of the object's bounding box; shading normals alone follow it.
    pub bump: [f64; VARIATIONS],
}

impl Default for Effects {
    fn default() -> Self {
        Self {
            diffuse_roughness: 0.0,
            second_lobe_weight: 0.0,
            second_lobe_roughness: 0.25,
            clearcoat_factor: 0.0,
            clearcoat_roughness: 0.1,
            clearcoat_ior: 1.5,
            metallic: 0.0,
            scatter_distance: 0.0,
            anisotropy_strength: 0.0,
            anisotropy_rotation: 0.0,
            sheen_color: [0.0; 3],
            sheen_roughness: 0.5,
            albedo_variation: [0.0; VARIATIONS],
            roughness_variation: [0.0; VARIATIONS],
            bump: [0.0; VARIATIONS],
        }
    }
}

impl Effects {
    /// Shows the keys that `model` has to the visitor.
    pub(super) fn describe(&mut self, model: &Model, v: &mut dyn Visitor) -> Result<()> {
        let plastic = matches!(model, Model::Plastic { .. });
        let metal = matches!(model, Model::Conductor { .. });
        let null = Self::default();
        let mut number =
            |key: &str, value: &mut f64, range: Range, default: f64| v.number(key, value, range, Some(default));
        if !metal {
            number(
                "diffuse_roughness",
                &mut self.diffuse_roughness,
                Range { min: 0.0, max: 2.0 },
                null.diffuse_roughness,
            )?;
            let lengths = Range { min: 0.0, max: LONGEST_SCATTER };
            number("scatter_distance", &mut self.scatter_distance, lengths, null.scatter_distance)?;
        }
        if plastic {
            let (unit, ior) = (Range::UNIT, Range::IOR);
            number("second_lobe_weight", &mut self.second_lobe_weight, unit, null.second_lobe_weight)?;
            number("second_lobe_roughness", &mut self.second_lobe_roughness, unit, null.second_lobe_roughness)?;
            number("clearcoat_factor", &mut self.clearcoat_factor, unit, null.clearcoat_factor)?;
            number("clearcoat_roughness", &mut self.clearcoat_roughness, unit, null.clearcoat_roughness)?;
            number("clearcoat_ior", &mut self.clearcoat_ior, ior, null.clearcoat_ior)?;
            number("metallic", &mut self.metallic, unit, null.metallic)?;
        }
        if plastic || metal {
            number("anisotropy_strength", &mut self.anisotropy_strength, Range::UNIT, null.anisotropy_strength)?;
            number("anisotropy_rotation", &mut self.anisotropy_rotation, Range::ANY, null.anisotropy_rotation)?;
        }
        if !metal {
            colour(v, "sheen_color", &mut self.sheen_color, Range::UNIT, Some(&null.sheen_color))?;
            v.number("sheen_roughness", &mut self.sheen_roughness, Range::UNIT, Some(null.sheen_roughness))?;
            variation(v, "albedo_variation", &mut self.albedo_variation)?;
        }
        if plastic || metal {
            variation(v, "roughness_variation", &mut self.roughness_variation)?;
        }
        variation(v, "bump", &mut self.bump)
    }
}

fn variation(v: &mut dyn Visitor, key: &str, values: &mut [f64; VARIATIONS]) -> Result<()> {
    let default = Some(&[0.0; VARIATIONS][..]);
    v.numbers(key, Numbers { values, suffixes: &VARIATION, range: Range::ANY, default, may_end_early: true })
}
