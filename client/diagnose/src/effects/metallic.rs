//! A metallic part of the surface: highlights take the base's colour, the diffuse part falls (glTF's metallic factor).

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "metallic",
    family: Family::Material,
    looks: "highlights take the base's colour, the diffuse part falls",
    looks_like: &["light colour"],
    separate_by: "put a white dielectric reference into the picture",
    variants: |context| {
        let weight = |name: &str| Direction::growing(format!("material.{name}.metallic"), 1.0);
        context.plastics().map(|(name, _)| Variant::of(name, vec![weight(name)])).collect()
    },
};
