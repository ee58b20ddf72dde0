//! A light that is not where the capture says: its position is off by a shift, in the light's own frame, in metres.

use super::{Direction, Effect, Family, Variant, xyz};
use gonio_scene::capture::LightKind;

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "light-position",
    family: Family::Light,
    looks: "gradients across photos, moved highlights",
    looks_like: &["pose-error"],
    separate_by: "photograph a plane at two depths",
    variants: |context| {
        let shift = |light: &gonio_scene::capture::Light| {
            let position = match light.kind {
                LightKind::Point { position, .. } | LightKind::Sphere { position, .. } => position,
                _ => return None,
            };
            let names = xyz(&format!("light.{}.position", light.name));
            let most = 0.5 * context.distance();
            let directions = names.into_iter().zip(position).map(|(n, x)| Direction::of(n, x, most)).collect();
            Some(Variant::of(light.name.clone(), directions))
        };
        context.lamps().filter_map(shift).collect()
    },
};
