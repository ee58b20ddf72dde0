//! A focal length that is not the file's.

use crate::effects::{Direction, Effect, Family, Variant};

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "focal-length",
    family: Family::Camera,
    looks: "everything is larger or smaller about the picture's middle",
    looks_like: &["lens-distortion", "mesh-scale"],
    separate_by: "calibrate the camera with a board",
    variants: |context| {
        let camera = &context.capture.camera;
        if context.frees("camera.fx") || context.frees("camera.fy") {
            return Vec::new();
        }
        let most = |focal: f64| 0.2 * focal;
        let x = Direction::of("camera.fx".to_owned(), camera.fx, most(camera.fx));
        let y = Direction::of("camera.fy".to_owned(), camera.fy, most(camera.fy));
        vec![Variant::of("", vec![x, y])]
    },
};
