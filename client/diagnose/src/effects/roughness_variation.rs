//! A roughness that varies over the object: polish, fingerprints, mould texture.
//!
//! roughness times exp of a sum of cosine products over the object's box (`roughness_variation`, see the format).

use super::{Direction, Effect, Family, Variant, surface_basis};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "roughness-variation",
    family: Family::Material,
    looks: "follows the object, in the highlights alone",
    looks_like: &["bumps"],
    separate_by: "light the part from three sides",
    variants: |context| {
        let basis =
            |name: &str| surface_basis(name, "roughness_variation").map(|n| Direction::of(n, 0.0, 1.0)).collect();
        context.plastics().map(|(name, _)| Variant::of(name, basis(name))).collect()
    },
};
