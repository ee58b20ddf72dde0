//! A base colour that varies over the object: paint, dirt, wear.
//!
//! base_color times exp of a sum of cosine products over the object's box (`albedo_variation`, see the format).

use super::{Direction, Effect, Family, Variant, surface_basis};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "albedo-variation",
    family: Family::Material,
    looks: "follows the object, in the diffuse part alone",
    looks_like: &["vignetting"],
    separate_by: "move the part: the pattern moves with it",
    variants: |context| {
        let basis = |name: &str| surface_basis(name, "albedo_variation").map(|n| Direction::of(n, 0.0, 1.0)).collect();
        context.materials().map(|m| Variant::of(m.name.clone(), basis(&m.name))).collect()
    },
};
