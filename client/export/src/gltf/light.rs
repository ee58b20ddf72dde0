//! A lamp of `KHR_lights_punctual`.

use crate::matrix::{Matrix, diagonal, with_z};
use crate::view::{Lamp, Shape};
use serde_json::{Value, json};

/// The lamp and its node's motion. Intensity is candela for points, lux for parallel light.
pub fn of(lamp: &Lamp, name: &str) -> (Value, Matrix) {
    let brightest = lamp.rgb.into_iter().fold(0.0, f64::max);
    let (kind, to_world) = match &lamp.shape {
        Shape::Point { position } | Shape::Sphere { position, .. } => {
            let mut place = diagonal([1.0; 3]);
            place.iter_mut().zip(position).for_each(|(row, shift)| row[3] = *shift);
            ("point", place)
        }
        // It shines along its node's -z.
        Shape::Parallel { direction } => ("directional", with_z(direction.map(|x| -x))),
    };
    let colour = lamp.rgb.map(|c| c / brightest);
    (json!({ "name": name, "type": kind, "color": colour, "intensity": brightest }), to_world)
}
