//! A light of finite size where the capture has a point: a Lambertian ball.
//!
//! Penumbra and widened highlights grow with the square of the radius to first order, so the square is scored.

use super::{Direction, Effect, Family, Structure, Variant};
use gonio_scene::capture::LightKind;

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "light-size",
    family: Family::Light,
    looks: "a penumbra that grows with distance, wider highlights",
    looks_like: &["roughness", "translucency"],
    separate_by: "repeat with the lamp at another distance",
    variants: |context| {
        let points = context.lamps().filter(|l| match l.kind {
            LightKind::Point { .. } => true,
            LightKind::Sphere { radius, .. } => radius == 0.0,
            _ => false,
        });
        points
            .map(|l| {
                let far = context.distance();
                let radius =
                    Direction::growing(format!("light.{}.radius", l.name), 0.4 * far).by_step(0.04 * far).squared();
                Variant::of(l.name.clone(), vec![radius]).adding(Structure::PointToSphere(l.name.clone()))
            })
            .collect()
    },
};
