//! A single photo whose exposure is not what the file says.

use crate::effects::{Direction, Effect, Family, Variant};

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "photo-exposure",
    family: Family::Camera,
    looks: "one photo is too bright or too dark",
    looks_like: &["light-flicker"],
    separate_by: "read that photo's exposure time again, or leave it out",
    variants: |context| {
        let names: Vec<String> = context.photos().map(|p| format!("photo.{}.gain", p.name())).collect();
        if names.len() < 2 || names.iter().any(|name| context.frees(name)) {
            return Vec::new();
        }
        let suspect = |(photo, p): (usize, &gonio_scene::capture::Photo)| {
            let gain = Direction::of_photo(&names, photo, p.gain, 0.8)?;
            let label = format!("photo {}", p.name());
            Some(Variant { of_photos: true, suspect: Some(photo), ..Variant::of(label, vec![gain]) })
        };
        context.photos().enumerate().filter_map(suspect).collect()
    },
};
