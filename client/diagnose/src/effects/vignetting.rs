//! Vignetting: the lens passes less light towards the image's corners.
//!
//! Light times 1 + k1 r^2 + k2 r^4, r the distance from the principal point over half the image's diagonal. k1 = -0.2 is a
//! cheap lens; natural vignetting cos^4 gives k1 of about -(diagonal / 2 / focal length)^2 * 2.

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "vignetting",
    family: Family::Camera,
    looks: "follows the image radius, all objects alike",
    looks_like: &["light-lobe"],
    separate_by: "shift the part in the frame: what the lens does stays where it is in the image",
    variants: |_| {
        let k = |n: &str, most| Direction::of(format!("sensor.vignetting.{n}"), 0.0, most);
        vec![Variant::of("", vec![k("k1", 0.9)]), Variant::of("two terms", vec![k("k1", 0.9), k("k2", 0.9)])]
    },
};
