//! Lens distortion that the calibration missed: radial terms k1 and k2 of Brown and Conrady, as OpenCV has them.

use super::{Direction, Effect, Family, Variant};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "lens-distortion",
    family: Family::Camera,
    looks: "a shift along the radius that grows with its cube",
    looks_like: &["pose-error"],
    separate_by: "photograph a calibration board",
    variants: |context| {
        let [k1, k2, ..] = context.capture.camera.distortion;
        let k = |name: &str, null| Direction::of(format!("camera.distortion.{name}"), null, 0.5);
        vec![Variant::of("", vec![k("k1", k1)]), Variant::of("two terms", vec![k("k1", k1), k("k2", k2)])]
    },
};
