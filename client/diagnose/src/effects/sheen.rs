//! Sheen: fibres or dust that scatter at grazing angles (KHR_materials_sheen; Estevez and Kulla 2017).

use super::{Direction, Effect, Family, Variant, rgb};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "sheen",
    family: Family::Material,
    looks: "excess at grazing angles",
    looks_like: &["ior"],
    separate_by: "repeat with a darker base colour",
    variants: |context| {
        let colour =
            |name: &str| rgb(&format!("material.{name}.sheen_color")).map(|n| Direction::growing(n, 1.0)).to_vec();
        let roughness = |name: &str| format!("material.{name}.sheen_roughness");
        context.plastics().map(|(name, _)| Variant::of(name, colour(name)).nuisance(roughness(name), 0.5)).collect()
    },
};
