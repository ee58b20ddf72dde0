//! A light that shines less to its sides: intensity times cos^n of the angle to its axis.
//!
//! n = 1 is a Lambertian chip, 10 and more a lens in front of it. The axis is the capture's `lobe_axis`: for a lamp on the
//! camera the optical axis; for another, the way to the parts.

use super::{Direction, Effect, Family, Variant, xyz};
use gonio_scene::capture::{Frame, LightKind};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "light-lobe",
    family: Family::Light,
    looks: "falls off with the lamp's own angle",
    looks_like: &["vignetting"],
    separate_by: "turn the lamp",
    variants: |context| {
        let (centre, _) = context.part_box();
        let lobe = |light: &gonio_scene::capture::Light| {
            let position = match light.kind {
                LightKind::Point { position, .. } | LightKind::Sphere { position, .. } => position,
                _ => return None,
            };
            let mut exponent = Direction::growing(format!("light.{}.lobe_exponent", light.name), 100.0).by_step(0.5);
            let mut variant = Variant::of(light.name.clone(), Vec::new());
            variant.free = vec![exponent.name.clone()];
            if light.frame == Frame::World {
                let axes = [0, 1, 2].map(|i| centre[i] - position[i]);
                let names = xyz(&format!("light.{}.lobe_axis", light.name));
                for ((name, value), now) in names.into_iter().zip(axes).zip([0.0, 0.0, 1.0]) {
                    exponent = exponent.with(name.clone(), now, value);
                    variant.settings.push((name, value));
                }
            }
            variant.directions.push(exponent);
            Some(variant)
        };
        context.lamps().filter_map(lobe).collect()
    },
};
