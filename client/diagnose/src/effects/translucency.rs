//! Translucency: light enters the part, scatters below its surface and leaves it elsewhere (normalised diffusion).
//!
//! What spreads is the light's second moment, which grows with the square of the mean free path to first order: the square
//! is scored. A step as short as the effect lets hardly a sample cross a shadow's edge, a long one sees thin parts only:
//! two are tried.

use super::{Direction, Effect, Family, Variant};
use gonio_scene::capture::{LONGEST_SCATTER, Model};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "translucency",
    family: Family::Material,
    looks: "softened terminators, thin parts glow",
    looks_like: &["light-size", "defocus"],
    separate_by: "repeat at another scale: a camera and a lamp twice as near",
    variants: |context| {
        let mut half = context.part_box().1;
        half.sort_by(f64::total_cmp);
        // Of the part, and in the photos.
        let (size, pixel) = (half[1], context.distance() / context.capture.camera.fx);
        let most = (0.5 * size).min(LONGEST_SCATTER);
        let mut variants = Vec::new();
        for material in context.materials().filter(|m| !matches!(m.model, Model::Conductor { .. })) {
            for part in [0.04, 0.12] {
                let step = (part * size).max(0.5 * pixel).min(most);
                let number = format!("material.{}.scatter_distance", material.name);
                let path = Direction::growing(number, most).by_step(step).squared();
                variants.push(Variant::of(format!("{}, about {:.1} mm", material.name, 1e3 * step), vec![path]));
            }
        }
        variants
    },
};
