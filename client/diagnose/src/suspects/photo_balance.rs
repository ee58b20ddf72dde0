//! A single photo whose white balance is not the others'.

use crate::context::Context;
use crate::effects::{Direction, Effect, Family, Variant, rgb};

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "photo-balance",
    family: Family::Camera,
    looks: "one photo has a tint",
    looks_like: &["white-balance"],
    separate_by: "develop that photo again with the others' white balance",
    variants: |context| {
        let suspect = |(photo, directions): (usize, Vec<Direction>)| {
            let label = format!("photo {}", context.capture.photos[photo].name());
            Variant { of_photos: true, suspect: Some(photo), ..Variant::of(label, directions) }
        };
        balances(context).into_iter().enumerate().map(suspect).collect()
    },
};

/// By photo: its red and blue beside its green, as a factor on all channels is an exposure. None where there is but one photo, or where the fit frees
/// balances.
pub(super) fn balances(context: &Context<'_>) -> Vec<Vec<Direction>> {
    let names = |channel: usize| -> Vec<String> {
        context.photos().map(|p| rgb(&format!("photo.{}.balance", p.name()))[channel].clone()).collect()
    };
    let names = [0, 1, 2].map(names);
    if names[0].len() < 2 || names.iter().flatten().any(|name| context.frees(name)) {
        return Vec::new();
    }
    let of = |(photo, p): (usize, &gonio_scene::capture::Photo)| {
        [0, 2].into_iter().filter_map(|c| Direction::of_photo(&names[c], photo, p.balance[c], 0.8)).collect()
    };
    context.photos().enumerate().map(of).collect()
}
