//! A white balance that drifts from photo to photo. The first photo's is the measure of the others', as the lights' colours hold what is common.

use super::photo_balance::balances;
use crate::effects::{Direction, Effect, Family, Variant};

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "white-balance",
    family: Family::Camera,
    looks: "a tint that changes from photo to photo",
    looks_like: &["light-flicker", "crosstalk"],
    separate_by: "set the camera's white balance by hand",
    variants: |context| {
        let all: Vec<Direction> = balances(context).into_iter().skip(1).flatten().collect();
        if all.is_empty() {
            return Vec::new();
        }
        vec![Variant { of_photos: true, of_held_out: Some("balance"), ..Variant::of("", all) }]
    },
};
