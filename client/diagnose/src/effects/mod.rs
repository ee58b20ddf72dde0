//! The catalogue of effects: what a simple renderer leaves out of real photographs, one file each.
//!
//! An effect is a patch to a capture: keys at their null value, which change nothing, and the names that it frees. To add
//! one, write a file with an `EFFECT` and name it in [`CATALOGUE`]; the keys themselves belong to the capture format.

mod albedo_variation;
mod ambient_light;
mod anisotropy;
mod black_level;
mod bumps;
mod clear_coat;
mod clipping;
mod crosstalk;
mod defocus;
mod diffuse_roughness;
mod lens_distortion;
mod light_flicker;
mod light_lobe;
mod light_position;
mod light_size;
mod metallic;
mod missing_object;
mod pose_error;
mod response_gamma;
mod roughness_variation;
mod second_light;
mod second_lobe;
mod sheen;
mod translucency;
mod veiling_glare;
mod vignetting;

pub use crate::variant::{Direction, Structure, Variant};

use crate::context::Context;
use crate::suspects::SUSPECTS;
use gonio_scene::capture::VARIATIONS;

/// Every effect that a diagnosis considers, by family.
pub const CATALOGUE: [&Effect; 26] = [
    &diffuse_roughness::EFFECT,
    &second_lobe::EFFECT,
    &clear_coat::EFFECT,
    &metallic::EFFECT,
    &anisotropy::EFFECT,
    &sheen::EFFECT,
    &albedo_variation::EFFECT,
    &roughness_variation::EFFECT,
    &translucency::EFFECT,
    &ambient_light::EFFECT,
    &second_light::EFFECT,
    &light_position::EFFECT,
    &light_size::EFFECT,
    &light_lobe::EFFECT,
    &light_flicker::EFFECT,
    &pose_error::EFFECT,
    &missing_object::EFFECT,
    &bumps::EFFECT,
    &vignetting::EFFECT,
    &response_gamma::EFFECT,
    &black_level::EFFECT,
    &clipping::EFFECT,
    &veiling_glare::EFFECT,
    &defocus::EFFECT,
    &lens_distortion::EFFECT,
    &crosstalk::EFFECT,
];

/// Every effect of the catalogue and every suspect among the file's numbers.
pub fn all() -> impl Iterator<Item = &'static Effect> {
    CATALOGUE.into_iter().chain(SUSPECTS)
}

/// Where an effect belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// What a surface does to light.
    Material,
    /// Where light comes from.
    Light,
    /// What stands where.
    Geometry,
    /// Lens, sensor and file.
    Camera,
}

/// One entry of the catalogue.
#[derive(Debug)]
pub struct Effect {
    /// Its name, as a diagnosis reports it.
    pub name: &'static str,
    /// Where it belongs.
    pub family: Family,
    /// How the residual looks.
    pub looks: &'static str,
    /// Effects that it is easily taken for.
    pub looks_like: &'static [&'static str],
    /// The measurement that tells it from those.
    pub separate_by: &'static str,
    /// The ways in which it may be present in a capture: one per subject (material, light, object) and per value of a
    /// nuisance that does not exist at the null. Empty where the capture has nothing that it could act on.
    pub variants: fn(&Context<'_>) -> Vec<Variant>,
}

/// The three names of a colour's channels.
pub(crate) fn rgb(name: &str) -> [String; 3] {
    ["r", "g", "b"].map(|c| format!("{name}.{c}"))
}

/// The three names of a point's coordinates.
pub(crate) fn xyz(name: &str) -> [String; 3] {
    ["x", "y", "z"].map(|c| format!("{name}.{c}"))
}

/// Coefficients over an object's box of degree at most 3, which are scored, and at most 4, 5 and 6.
const DEGREES: [usize; 4] = [19, 34, 55, VARIATIONS];

/// A material that varies over its object: scored in the coarsest patterns, fitted with as many as the photos support.
fn over_the_surface(material: &str, key: &str, most: f64) -> Variant {
    let names: Vec<String> = (0..VARIATIONS).map(|k| format!("material.{material}.{key}.{k}")).collect();
    let directions = names[..DEGREES[0]].iter().map(|n| Direction::of(n.clone(), 0.0, most)).collect();
    let finer = DEGREES.windows(2).map(|d| names[d[0]..d[1]].to_vec()).collect();
    Variant { finer, free: names, ..Variant::of(material, directions) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn names_are_unique_and_known_to_each_other() {
        let names: BTreeSet<_> = all().map(|e| e.name).collect();
        assert_eq!(names.len(), all().count());
        for effect in all() {
            let known = |n: &&str| names.contains(n) || ["ior", "roughness", "light colour", "exposure"].contains(n);
            assert!(effect.looks_like.iter().all(known), "{}", effect.name);
        }
    }
}
