//! A base colour that varies over the object: paint, dirt, wear.
//!
//! base_color times exp of a sum of cosine products over the object's box (`albedo_variation`, see the format).

use super::{Effect, Family, over_the_surface};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "albedo-variation",
    family: Family::Material,
    looks: "follows the object, in the diffuse part alone",
    looks_like: &["vignetting"],
    separate_by: "move the part: the pattern moves with it",
    variants: |context| context.materials().map(|m| over_the_surface(&m.name, "albedo_variation", 1.0)).collect(),
};
