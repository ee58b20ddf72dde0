//! A second lobe: part of the surface is smoother or rougher than the rest.
//!
//! A blend of two whole plastics that differ in roughness; the second's is tried at parts and multiples of the first's.

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "second-lobe",
    family: Family::Material,
    looks: "a skirt or a peak over the half angle",
    looks_like: &["veiling-glare", "clear-coat"],
    separate_by: "sweep the half angle",
    variants: |context| {
        let mut variants = Vec::new();
        for (name, roughness) in context.plastics() {
            for ratio in [0.5, 0.7, 1.6] {
                let second = (ratio * roughness).clamp(0.03, 0.98);
                let key = format!("material.{name}.second_lobe_roughness");
                let weight = Direction::growing(format!("material.{name}.second_lobe_weight"), 0.9).by_step(0.25).with(
                    key.clone(),
                    0.25,
                    second,
                );
                variants
                    .push(Variant::of(format!("{name}, roughness {second:.2}"), vec![weight]).nuisance(key, second));
            }
        }
        variants
    },
};
