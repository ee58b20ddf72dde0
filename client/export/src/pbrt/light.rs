//! Lamps and sky as pbrt's lights.

use super::{list, octahedron};
use crate::Result;
use crate::files::FileMap;
use crate::ledger::Ledger;
use crate::matrix::columns;
use crate::scene::Scene;
use crate::view::{Shape, View};
use gonio_scene::capture::LightKind;
use gonio_scene::image::encode_exr;
use std::fmt::Write;

/// The maps, as squares.
///
/// # Errors
/// A map that cannot be encoded.
pub fn maps(scene: &Scene<'_>) -> Result<FileMap> {
    scene
        .maps
        .values()
        .map(|map| Ok((map.file.clone(), encode_exr(&map.file, &octahedron::square(&map.image))?)))
        .collect()
}

/// The lights of a photo.
pub fn write(scene: &Scene<'_>, view: &View, out: &mut String) -> std::fmt::Result {
    for lamp in &view.lamps {
        let rgb = list(&lamp.rgb);
        match &lamp.shape {
            Shape::Point { position } => {
                writeln!(out, "LightSource \"point\" \"rgb I\" [ {rgb} ] \"point3 from\" [ {} ]", list(position))?;
            }
            Shape::Parallel { direction } => {
                let from = list(&direction.map(|x| -x));
                writeln!(out, "LightSource \"distant\" \"rgb L\" [ {rgb} ] \"point3 from\" [ {from} ]")?;
                writeln!(out, "    \"point3 to\" [ 0 0 0 ]")?;
            }
            Shape::Sphere { position, radius } => {
                let radiance = list(&lamp.radiance(*radius));
                writeln!(out, "AttributeBegin\n    Translate {}", list(position))?;
                writeln!(out, "    AreaLightSource \"diffuse\" \"rgb L\" [ {radiance} ]")?;
                writeln!(out, "    Shape \"sphere\" \"float radius\" [ {radius} ]\nAttributeEnd")?;
            }
        }
    }
    if view.constant != [0.0; 3] {
        writeln!(out, "LightSource \"infinite\" \"rgb L\" [ {} ]", list(&view.constant))?;
    }
    if let Some((sky, map)) = view.map.as_ref().and_then(|sky| Some((sky, scene.maps.get(&sky.path)?))) {
        writeln!(out, "AttributeBegin\n    ConcatTransform [ {} ]", list(&columns(&sky.to_world)))?;
        writeln!(out, "    LightSource \"infinite\" \"string filename\" [ \"{}\" ]", map.file)?;
        writeln!(out, "        \"float scale\" [ {} ]\nAttributeEnd", sky.scale)?;
    }
    Ok(())
}

/// Judges the lights' numbers.
pub fn judge(scene: &Scene<'_>, ledger: &mut Ledger) {
    for light in &scene.capture.lights {
        let name = format!("light.{}", light.name);
        match light.kind {
            LightKind::Point { .. } => ledger.exact(&name, "point"),
            LightKind::Sphere { .. } => ledger.exact(&name, "a sphere with a diffuse area light"),
            LightKind::Directional { .. } => ledger.exact(&name, "distant"),
            LightKind::Constant { .. } => ledger.exact(&name, "infinite"),
            LightKind::Map { .. } => {
                ledger.approximated(&name, "infinite, its map resampled to pbrt's square of equal areas");
            }
        }
        ledger.lose_lobe(light, "the lamp shines to all sides as brightly as along its axis");
    }
}
