//! A black level that was not subtracted: the photo value of no light, added whatever the exposure.

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "black-level",
    family: Family::Camera,
    looks: "constant, whatever the exposure",
    looks_like: &["ambient-light", "veiling-glare", "response-gamma"],
    separate_by: "take a photo with the lens cap on",
    variants: |context| {
        vec![Variant::of("", vec![Direction::of("sensor.black_level".to_owned(), 0.0, 0.3 * context.peak.max(1e-6))])]
    },
};
