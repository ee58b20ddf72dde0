//! A principal point that is not the file's.

use crate::effects::{Direction, Effect, Family, Variant};

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "principal-point",
    family: Family::Camera,
    looks: "dipoles along edges, the same way in every photo",
    looks_like: &["pose-error", "photo-pose"],
    separate_by: "calibrate the camera with a board",
    variants: |context| {
        let camera = &context.capture.camera;
        if context.frees("camera.cx") || context.frees("camera.cy") {
            return Vec::new();
        }
        let most = 0.1 * f64::from(camera.width);
        let x = Direction::of("camera.cx".to_owned(), camera.cx, most);
        let y = Direction::of("camera.cy".to_owned(), camera.cy, most);
        vec![Variant::of("", vec![x, y])]
    },
};
