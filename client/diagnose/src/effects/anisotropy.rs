//! Anisotropy: grooves make highlights longer across than along them (KHR_materials_anisotropy).
//!
//! GGX alpha grows with the square of the strength, which is what is scored; the direction is tried at some angles.

use super::{Direction, Effect, Family, Variant};
use std::f64::consts::PI;

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "anisotropy",
    family: Family::Material,
    looks: "a quadrupole round a highlight",
    looks_like: &["bumps"],
    separate_by: "turn the part",
    variants: |context| {
        let mut variants = Vec::new();
        for (name, _) in context.plastics() {
            for quarter in 0..4 {
                let angle = PI / 4.0 * f64::from(quarter);
                let key = format!("material.{name}.anisotropy_rotation");
                let strength = Direction::growing(format!("material.{name}.anisotropy_strength"), 0.95)
                    .by_step(0.3)
                    .squared()
                    .with(key.clone(), 0.0, angle);
                let label = format!("{name}, {:.0} degrees", angle.to_degrees());
                variants.push(Variant::of(label, vec![strength]).nuisance(key, angle));
            }
        }
        variants
    },
};
