//! The base colour of a material that the fit takes from the file: a table, a board.

use crate::effects::{Direction, Effect, Family, Variant, rgb};
use gonio_scene::capture::Model;

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "base-color",
    family: Family::Material,
    looks: "one object is too bright, too dark or of another hue",
    looks_like: &["crosstalk", "ambient-light"],
    separate_by: "photograph a gray card beside it",
    variants: |context| {
        let mut variants = Vec::new();
        for material in &context.capture.materials {
            let key = format!("material.{}.base_color", material.name);
            let base_color = match &material.model {
                Model::Lambert { base_color } | Model::Plastic { base_color, .. } => base_color,
                _ => continue,
            };
            if !context.frees(&key) {
                let each = rgb(&key).into_iter().zip(base_color).map(|(name, c)| Direction::of(name, *c, 1.0));
                variants.push(Variant::of(material.name.clone(), each.collect()));
            }
        }
        variants
    },
};
