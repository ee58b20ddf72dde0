//! Clipping: photo values end at a level below the one that the capture states.
//!
//! value = min(value, level). At the null (no level) it has no derivative: levels at parts of the largest photo value
//! are tried, each by the whole difference that it would make.

use super::{Direction, Effect, Family, Variant};

/// The level that stands for none.
const NONE: f64 = 1e6;

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "clipping",
    family: Family::Camera,
    looks: "one-sided, in the brightest pixels",
    looks_like: &["response-gamma"],
    separate_by: "repeat with a shorter exposure",
    variants: |context| {
        [1.0, 0.97, 0.93, 0.85]
            .iter()
            .map(|part| {
                let level = part * context.peak;
                let down = Direction {
                    most: NONE,
                    ..Direction::of("sensor.clip_level".to_owned(), NONE, NONE).by_step(NONE - level)
                };
                Variant {
                    settings: vec![("sensor.clip_level".to_owned(), level)],
                    ..Variant::of(format!("at {level:.3}"), vec![down])
                }
            })
            .collect()
    },
};
