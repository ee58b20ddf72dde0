//! Lamps and sky as Mitsuba's emitters.

use super::node::{Node, Value};
use crate::Result;
use crate::files::FileMap;
use crate::ledger::Ledger;
use crate::matrix::{Matrix, product};
use crate::scene::Scene;
use crate::view::{Lamp, Shape, View};
use gonio_scene::capture::LightKind;
use gonio_scene::image::{Image, encode_exr};

/// Columns: the axes of Mitsuba's map in a capture's map. Its map has +y on top and its middle column along +z.
const TO_MAP: Matrix = [[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// A lamp.
pub fn emitter(lamp: &Lamp) -> Node {
    match &lamp.shape {
        Shape::Point { position } => Node::new("emitter", "point")
            .with("position", Value::Point(*position))
            .with("intensity", Value::Rgb(lamp.rgb)),
        Shape::Sphere { position, radius } => {
            let area = Node::new("emitter", "area").with("radiance", Value::Rgb(lamp.radiance(*radius)));
            Node::new("shape", "sphere")
                .with("center", Value::Point(*position))
                .with("radius", Value::Number(*radius))
                .with("emitter", Value::Node(area))
        }
        Shape::Parallel { direction } => Node::new("emitter", "directional")
            .with("direction", Value::Direction(*direction))
            .with("irradiance", Value::Rgb(lamp.rgb)),
    }
}

/// The sky of a photo, and the files that it needs. A scene of Mitsuba's has one: a constant beside a map goes into it.
///
/// # Errors
/// A map that cannot be encoded.
#[allow(clippy::cast_possible_truncation)] // A map is single precision.
pub fn sky(scene: &Scene<'_>, view: &View) -> Result<(Option<Node>, FileMap)> {
    let mut files = FileMap::new();
    let Some((sky, map)) = view.map.as_ref().and_then(|sky| Some((sky, scene.maps.get(&sky.path)?))) else {
        let constant = || Node::new("emitter", "constant").with("radiance", Value::Rgb(view.constant));
        return Ok(((view.constant != [0.0; 3]).then(constant), files));
    };
    let (file, scale) = if view.constant == [0.0; 3] {
        files.insert(map.file.clone(), encode_exr(&map.file, &map.image)?);
        (map.file.clone(), sky.scale)
    } else {
        let file = format!("maps/photo-{}.exr", view.stem);
        let both = |p: &[f32; 3]| [0, 1, 2].map(|c| (f64::from(p[c]) * sky.scale + view.constant[c]) as f32);
        let image = Image { pixels: map.image.pixels.iter().map(both).collect(), ..*map.image.as_ref() };
        files.insert(file.clone(), encode_exr(&file, &image)?);
        (file, 1.0)
    };
    let node = Node::new("emitter", "envmap")
        .with("filename", Value::File(file))
        .with("scale", Value::Number(scale))
        .with("to_world", Value::Matrix(product(&sky.to_world, &TO_MAP)));
    Ok((Some(node), files))
}

/// Judges the lights' numbers.
pub fn judge(scene: &Scene<'_>, ledger: &mut Ledger) {
    for light in &scene.capture.lights {
        let name = format!("light.{}", light.name);
        let place = match light.kind {
            LightKind::Point { .. } => "point",
            LightKind::Sphere { .. } => "a sphere with an area emitter",
            LightKind::Directional { .. } => "directional",
            LightKind::Map { .. } => "envmap; light of constant radiance beside it is in its pixels",
            LightKind::Constant { .. } => "constant, or in the pixels of an envmap beside it",
        };
        ledger.exact(&name, place);
        ledger
            .lose_lobe(light, "Mitsuba has no lamp of this lobe: it shines to all sides as brightly as along its axis");
    }
}
