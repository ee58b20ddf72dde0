//! A part that is not where the capture says: a shift in metres and a rotation vector in radians, about its origin.

use super::{Direction, Effect, Family, Variant, xyz};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "pose-error",
    family: Family::Geometry,
    looks: "dipoles along edges",
    looks_like: &["lens-distortion", "light-position"],
    separate_by: "compare several views: a wrong pose is the same in all",
    variants: |context| {
        let pose = |part: usize| {
            let name = &context.capture.objects[part].name;
            let shift = xyz(&format!("object.{name}.translation")).map(|n| Direction::of(n, 0.0, 0.02));
            let turn = xyz(&format!("object.{name}.rotation")).map(|n| Direction::of(n, 0.0, 0.3));
            Variant::of(name.clone(), shift.into_iter().chain(turn).collect())
        };
        context.parts().map(pose).collect()
    },
};
