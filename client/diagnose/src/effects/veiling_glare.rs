//! Veiling glare: the lens scatters a part of all light over a wide halo.
//!
//! A pixel gets (1 - fraction) of its own light and `fraction` of light from around, by a Gaussian of standard deviation
//! `glare_width` pixels. ISO 9358 measures the integral of it; 0.01 to 0.05 for lenses of cameras and telephones.

use super::{Direction, Effect, Family, Variant};

const STEP: f64 = 0.05;

/// Pixels: what spreads light less far is no veil but the lens' blur, which defocus stands for.
const NARROWEST: f64 = 1.5;

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "veiling-glare",
    family: Family::Camera,
    looks: "a halo across silhouettes",
    looks_like: &["ambient-light", "second-lobe", "black-level"],
    separate_by: "photograph a black trap in front of a bright ground",
    variants: |context| {
        let camera = &context.capture.camera;
        let width = f64::from(camera.width.max(camera.height));
        [0.03, 0.1, 0.25]
            .iter()
            .map(|part| {
                let pixels = part * width;
                let fraction = Direction::growing("camera.glare_fraction".to_owned(), 0.5).by_step(STEP).with(
                    "camera.glare_width".to_owned(),
                    20.0,
                    pixels,
                );
                Variant::of(format!("width {pixels:.0} px"), vec![fraction])
                    .nuisance("camera.glare_width".to_owned(), pixels)
                    .only_above("camera.glare_width".to_owned(), NARROWEST)
            })
            .collect()
    },
};
