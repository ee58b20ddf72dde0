//! A single photo whose white balance is not the others'.

use crate::effects::{Direction, Effect, Family, Variant, rgb};

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "photo-balance",
    family: Family::Camera,
    looks: "one photo has a tint",
    looks_like: &["white-balance"],
    separate_by: "develop that photo again with the others' white balance",
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
        let suspect = |(photo, p): (usize, &gonio_scene::capture::Photo)| {
            let label = format!("photo {}", p.name());
            Variant { of_photos: true, suspect: Some(photo), ..Variant::of(label, of(photo, p)) }
        };
        context.photos().enumerate().map(suspect).collect()
    },
};
