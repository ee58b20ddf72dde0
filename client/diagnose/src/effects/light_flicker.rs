//! A lamp or shutter that is not steady: a factor on each photo's light.
//!
//! The factors are relative to the first photo's, as the lights' intensities hold their common part.

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "light-flicker",
    family: Family::Light,
    looks: "follows the photo alone",
    looks_like: &["exposure"],
    separate_by: "repeat a photo from the same place",
    variants: |context| {
        let gain = |p: &gonio_scene::capture::Photo| Direction::of(format!("photo.{}.gain", p.name()), p.gain, 0.8);
        let gains: Vec<Direction> = context.capture.photos.iter().skip(1).map(gain).collect();
        if gains.is_empty() { Vec::new() } else { vec![Variant { of_photos: true, ..Variant::of("", gains) }] }
    },
};
