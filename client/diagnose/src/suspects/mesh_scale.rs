//! A mesh that is larger or smaller than its file says, about its own origin.

use crate::effects::{Direction, Effect, Family, Variant, xyz};

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "mesh-scale",
    family: Family::Geometry,
    looks: "dipoles along edges, outwards all round",
    looks_like: &["focal-length", "pose-error"],
    separate_by: "measure the part with a calliper",
    variants: |context| {
        let mut variants = Vec::new();
        for part in context.parts() {
            let object = &context.capture.objects[part];
            let key = format!("object.{}.scale", object.name);
            if context.frees(&key) {
                continue;
            }
            let [x, y, z] = xyz(&key);
            let [a, b, c] = object.scale;
            let along = vec![(y, b / a), (z, c / a)];
            let scale = Direction { along, ..Direction::of(x, a, 0.2 * a) };
            let variant = Variant::of(object.name.clone(), vec![scale]);
            variants.push(Variant { free: vec![key.clone()], gray: vec![key], ..variant });
        }
        variants
    },
};
