//! Defocus: a lens of finite aperture is sharp at one distance alone.
//!
//! Thin lens: a point at depth z is spread over a disk of aperture_radius |1 - z / focus_distance|, seen at z. The blur's area
//! grows with the square of the aperture, which is what is scored.

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "defocus",
    family: Family::Camera,
    looks: "edges soften with depth",
    looks_like: &["pose-error", "translucency"],
    separate_by: "refocus, or close the aperture",
    variants: |context| {
        let distance = context.distance();
        [0.75, 1.0, 1.35]
            .iter()
            .map(|part| {
                // A disk of three pixels at a depth a third beyond the focus.
                let step = 4.5 * distance / context.capture.camera.fx;
                let focus = part * distance;
                let radius = Direction::growing("camera.aperture_radius".to_owned(), 0.1 * distance)
                    .by_step(step)
                    .squared()
                    .with("camera.focus_distance".to_owned(), 1.0, focus);
                Variant::of(format!("focus at {focus:.2} m"), vec![radius])
                    .nuisance("camera.focus_distance".to_owned(), focus)
            })
            .collect()
    },
};
