//! Crosstalk: a part of each channel's light is counted in another.
//!
//! Six off-diagonals of the matrix between light and channels; the diagonal is absorbed by the light's colour. Filters that
//! overlap, or a colour matrix meant for other light, give some per cent.

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "crosstalk",
    family: Family::Camera,
    looks: "a fixed mixing of the channels",
    looks_like: &["light colour"],
    separate_by: "photograph a colour chart in the same light",
    variants: |_| {
        let entry = |n: &str| Direction::of(format!("sensor.crosstalk.{n}"), 0.0, 0.5);
        vec![Variant::of("", ["rg", "rb", "gr", "gb", "br", "bg"].map(entry).to_vec())]
    },
};
