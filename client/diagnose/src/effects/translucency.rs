//! Translucency: light leaves the base some way from where it entered.
//!
//! `mean_free_path`, in metres, sets how far; to first order what is lost at edges grows with its square.

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "translucency",
    family: Family::Material,
    looks: "softened terminators, thin parts glow",
    looks_like: &["light-size", "defocus"],
    separate_by: "photograph the same material at another scale",
    variants: |context| {
        let (_, half) = context.part_box();
        let size = half.iter().copied().fold(f64::INFINITY, f64::min);
        let path = |name: &str| {
            Direction::growing(format!("material.{name}.mean_free_path"), size).by_step(0.1 * size).squared()
        };
        let known = context.capture.numbers();
        context
            .plastics()
            .filter(|(n, _)| known.contains_key(&format!("material.{n}.mean_free_path")))
            .map(|(name, _)| Variant::of(name, vec![path(name)]))
            .collect()
    },
};
