//! Something beside the part that the capture does not list: it tints the light, casts a shadow or stands in the picture.
//!
//! Tried as an upright wall (a Lambertian box) at several sides, by the whole difference that it would make: a black one,
//! and a white one, in each channel, whose mixture is a wall of any colour. The refit then moves, turns, sizes and
//! colours the best.

use super::{Direction, Effect, Family, Structure, Variant, rgb};
use gonio_scene::capture::{Material, Model, Object};
use std::f64::consts::PI;

/// A box: x 0..1 (thickness), y -0.5..0.5 (width), z 0..1 (height).
const BOX: &[u8] = b"ply
format ascii 1.0
element vertex 8
property float x
property float y
property float z
element face 6
property list uchar int vertex_indices
end_header
0 -0.5 0
1 -0.5 0
1 0.5 0
0 0.5 0
0 -0.5 1
1 -0.5 1
1 0.5 1
0 0.5 1
4 0 3 2 1
4 4 5 6 7
4 0 1 5 4
4 1 2 6 5
4 2 3 7 6
4 3 0 4 7
";

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "missing-object",
    family: Family::Geometry,
    looks: "tinted light, or a shadow, from one side of the part",
    looks_like: &["ambient-light", "second-light"],
    separate_by: "hang black cloth on that side",
    variants: |context| {
        let (centre, half) = context.part_box();
        let reach = libm::hypot(half[0], half[1]);
        let floor = centre[2] - half[2];
        let wall = |index: usize, azimuth: f64, distance: f64| {
            let name = format!("missing-{index}");
            let (c, s) = (libm::cos(azimuth), libm::sin(azimuth));
            // About as high as a part and much wider: a higher one would stand before every camera on its side.
            let (thick, wide, high) = (0.02 * reach, 7.0 * reach, 2.0 * reach);
            let object_to_world = [
                [c * thick, -s * wide, 0.0, centre[0] + c * distance],
                [s * thick, c * wide, 0.0, centre[1] + s * distance],
                [0.0, 0.0, high, floor],
                [0.0, 0.0, 0.0, 1.0],
            ];
            let object = Object {
                name: name.clone(),
                mesh: "missing-object.ply".to_owned(),
                material: name.clone(),
                object_to_world,
                presence: 0.0,
                ..Object::default()
            };
            let material =
                Material { name: name.clone(), model: Model::Lambert { base_color: [0.5; 3] }, ..Material::default() };
            let number = |key: &str| format!("object.{name}.{key}");
            let presence = number("presence");
            let colour = rgb(&format!("material.{name}.base_color"));
            let coloured = |channel: usize, albedo: f64| {
                let start = Direction::of(presence.clone(), 0.0, 3.0).by_step(1.0).in_channel(channel);
                colour.iter().fold(start, |d, c| d.with(c.clone(), 0.5, albedo))
            };
            let directions = (0..3).flat_map(|channel| [coloured(channel, 0.0), coloured(channel, 1.0)]).collect();
            let mut variant =
                Variant::of(format!("at {:.0} degrees, {distance:.3} m", azimuth.to_degrees()), directions)
                    .adding(Structure::Object(Box::new((object, material)), BOX));
            variant.settings = vec![(presence, 1.0)];
            variant.settings.extend(colour.map(|c| (c, 0.5)));
            let scale = [number("scale.y"), number("scale.z")];
            variant.free =
                vec![format!("material.{name}.base_color"), number("translation.x"), number("translation.y")];
            variant.free.push(number("rotation.z"));
            variant.free.extend(scale.clone());
            let moved = |x: f64, y: f64| vec![(number("translation.x"), x), (number("translation.y"), y)];
            // An end moves along the wall while the other stays: which one is seen differs between photos.
            let end = |side: f64| {
                let mut step = vec![(scale[0].clone(), 2.0 * reach / wide)];
                step.extend(moved(-0.5 * side * 2.0 * reach * s, 0.5 * side * 2.0 * reach * c));
                step
            };
            variant
                .searching_along(moved(0.5 * reach * c, 0.5 * reach * s))
                .searching_along(end(1.0))
                .searching_along(end(-1.0))
                .searching(&[number("rotation.z")], 0.2)
                .searching(&scale[1..], 0.3)
        };
        (0..8).map(|i| wall(i, PI / 4.0 * i as f64, 2.2 * reach)).collect()
    },
};
