//! A rough diffuse base: facets that shade and mask each other (Oren and Nayar 1994), sigma in radians.
//!
//! To first order the effect grows with sigma squared, which is what is scored.

use super::{Direction, Effect, Family, Variant};
use gonio_scene::capture::NULL_STEP;

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "diffuse-roughness",
    family: Family::Material,
    looks: "bright where light and view agree, and at the limb",
    looks_like: &["ambient-light", "response-gamma"],
    separate_by: "move the light round the part",
    variants: |context| {
        let sigma = |name: &str| {
            let number = format!("material.{name}.diffuse_roughness");
            // At its null the plane holds a difference over this step.
            Direction { step_at_null: Some(NULL_STEP), ..Direction::growing(number, 1.2).squared() }
        };
        context.plastics().map(|(name, _)| Variant::of(name, vec![sigma(name)])).collect()
    },
};
