//! A roughness that varies over the object: polish, fingerprints, mould texture.
//!
//! roughness times exp of a sum of cosine products over the object's box (`roughness_variation`, see the format).

use super::{Effect, Family, over_the_surface};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "roughness-variation",
    family: Family::Material,
    looks: "follows the object, in the highlights alone",
    looks_like: &["bumps"],
    separate_by: "light the part from three sides",
    variants: |context| {
        context.plastics().map(|(name, _)| over_the_surface(name, "roughness_variation", 1.0)).collect()
    },
};
