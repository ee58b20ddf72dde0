//! The colour and intensity of a light that the fit takes from the file.

use crate::effects::{Direction, Effect, Family, Variant, rgb};
use gonio_scene::capture::LightKind;

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "lamp-color",
    family: Family::Light,
    looks: "a tint of all that one lamp lights",
    looks_like: &["crosstalk", "ambient-light"],
    separate_by: "photograph a gray card in the same light",
    variants: |context| {
        let mut variants = Vec::new();
        for light in &context.capture.lights {
            let (key, value) = match &light.kind {
                LightKind::Point { intensity, .. } | LightKind::Sphere { intensity, .. } => ("intensity", intensity),
                LightKind::Directional { irradiance, .. } => ("irradiance", irradiance),
                LightKind::Constant { radiance } => ("radiance", radiance),
                _ => continue,
            };
            let name = format!("light.{}.{key}", light.name);
            if !context.frees(&name) {
                let each = rgb(&name).into_iter().zip(value).map(|(name, v)| Direction::of(name, *v, 10.0 * v));
                variants.push(Variant::of(light.name.clone(), each.collect()));
            }
        }
        variants
    },
};
