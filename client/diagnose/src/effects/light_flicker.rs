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
        let names: Vec<String> = context.photos().map(|p| format!("photo.{}.gain", p.name())).collect();
        let photos = context.photos().enumerate().skip(1);
        let gains: Vec<Direction> = photos.filter_map(|(i, p)| Direction::of_photo(&names, i, p.gain, 0.8)).collect();
        if gains.is_empty() {
            return Vec::new();
        }
        vec![Variant { of_photos: true, of_held_out: Some("gain"), ..Variant::of("", gains) }]
    },
};
