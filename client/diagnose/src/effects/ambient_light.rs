//! Ambient light: the same radiance from everywhere, as a lit room has where the capture has darkness.

use super::{Direction, Effect, Family, Structure, Variant, rgb};
use gonio_scene::capture::{Frame, Light, LightKind};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "ambient-light",
    family: Family::Light,
    looks: "fills shadows, follows albedo and openness",
    looks_like: &["black-level", "veiling-glare"],
    separate_by: "take a photo with the lamp off",
    variants: |context| {
        let known = context.capture.lights.iter().any(|l| matches!(l.kind, LightKind::Constant { .. }));
        if known {
            return Vec::new();
        }
        let light = Light {
            name: "ambient".to_owned(),
            frame: Frame::World,
            kind: LightKind::Constant { radiance: [0.0; 3] },
            ..Light::default()
        };
        let radiance = rgb("light.ambient.radiance").map(|n| Direction::growing(n, 1e6));
        vec![Variant::of("", radiance.to_vec()).adding(Structure::Light(light))]
    },
};
