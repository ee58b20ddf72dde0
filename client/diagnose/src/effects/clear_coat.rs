//! A clear coat: a smooth dielectric layer over the rest, which it darkens (KHR_materials_clearcoat).
//!
//! Its roughness is tried at some values; its index is 1.5, as the extension has it, until the refit.

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect =
    Effect {
        name: "clear-coat",
        family: Family::Material,
        looks: "a sharp peak over a dull one, a darker base",
        looks_like: &["second-lobe"],
        separate_by: "look at grazing views",
        variants: |context| {
            let mut variants = Vec::new();
            for (name, _) in context.plastics() {
                for roughness in [0.06, 0.11, 0.18, 0.28] {
                    let key = format!("material.{name}.clearcoat_roughness");
                    let factor = Direction::growing(format!("material.{name}.clearcoat_factor"), 1.0)
                        .by_step(0.3)
                        .with(key.clone(), 0.1, roughness);
                    variants.push(
                        Variant::of(format!("{name}, roughness {roughness:.2}"), vec![factor]).nuisance(key, roughness),
                    );
                }
            }
            variants
        },
    };
