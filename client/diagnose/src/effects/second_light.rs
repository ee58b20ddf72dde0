//! A second light: another lamp or a window, that the capture does not list.
//!
//! A point light at rest in the world; where is tried at places round the parts, twice as far as the cameras.

use super::{Direction, Effect, Family, Structure, Variant, rgb, xyz};
use gonio_scene::capture::{Frame, Light, LightKind};
use std::f64::consts::PI;

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "second-light",
    family: Family::Light,
    looks: "another shadow, another highlight",
    looks_like: &["ambient-light", "missing-object"],
    separate_by: "take a photo with the known lamp off",
    variants: |context| {
        let (centre, _) = context.part_box();
        let far = 2.0 * context.distance();
        let place = |azimuth: f64, height: f64| {
            let flat = far * libm::cos(height);
            let (x, y) = (flat * libm::cos(azimuth), flat * libm::sin(azimuth));
            [centre[0] + x, centre[1] + y, centre[2] + far * libm::sin(height)]
        };
        let round = (0..4).map(|i| place(PI / 2.0 * f64::from(i) + 0.4, 0.6));
        let places: Vec<[f64; 3]> = round.chain([place(0.0, PI / 2.0)]).collect();
        let variant = |(i, position): (usize, &[f64; 3])| {
            let name = format!("second-light-{i}");
            let kind = LightKind::Point { position: *position, intensity: [0.0; 3] };
            let light = Light { name: name.clone(), frame: Frame::World, kind, ..Light::default() };
            let intensity = format!("light.{name}.intensity");
            let colour = rgb(&intensity).map(|n| Direction::growing(n, 1e6)).to_vec();
            let [p, q, s] = *position;
            Variant {
                free: vec![intensity, format!("light.{name}.position")],
                ..Variant::of(format!("from ({p:.2}, {q:.2}, {s:.2})"), colour).adding(Structure::Light(light))
            }
            .searching(&xyz(&format!("light.{name}.position")), 0.5 * far)
        };
        places.iter().enumerate().map(variant).collect()
    },
};
