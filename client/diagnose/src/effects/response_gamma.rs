//! A response that is not linear: photo value = exposed light ^ gamma.
//!
//! Gamma 1 is a linear sensor, 1 / 2.2 a picture made for a screen, and what a raw converter's "contrast" leaves is near 0.9.

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "response-gamma",
    family: Family::Camera,
    looks: "a function of the signal alone",
    looks_like: &["black-level", "veiling-glare"],
    separate_by: "bracket the exposures: a response is the same function of the signal at every exposure",
    variants: |_| vec![Variant::of("", vec![Direction::of("sensor.gamma".to_owned(), 1.0, 0.6)])],
};
