//! A white balance that drifts from photo to photo. The first photo's is the measure of the others', as the lights' colours hold what is common.

use crate::effects::{Direction, Effect, Family, Variant, rgb};

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "white-balance",
    family: Family::Camera,
    looks: "a tint that changes from photo to photo",
    looks_like: &["light-flicker", "crosstalk"],
    separate_by: "set the camera's white balance by hand",
    variants: |context| {
        let names = |channel: usize| -> Vec<String> {
            context.photos().map(|p| rgb(&format!("photo.{}.balance", p.name()))[channel].clone()).collect()
        };
        let names = [0, 1, 2].map(names);
        if names[0].len() < 2 || names.iter().flatten().any(|name| context.frees(name)) {
            return Vec::new();
        }
        let of = |photo: usize, p: &gonio_scene::capture::Photo| -> Vec<Direction> {
            // Green stays: a factor on all channels is an exposure.
            [0, 2].into_iter().filter_map(|c| Direction::of_photo(&names[c], photo, p.balance[c], 0.8)).collect()
        };
        let all: Vec<Direction> = context.photos().enumerate().skip(1).flat_map(|(photo, p)| of(photo, p)).collect();
        vec![Variant { of_photos: true, of_held_out: Some("balance"), ..Variant::of("", all) }]
    },
};
