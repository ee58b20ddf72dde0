//! A photo's lamps and sky as UsdLux lights.

use super::place;
use super::text::triple;
use crate::ledger::Ledger;
use crate::matrix::{Matrix, product, with_z};
use crate::name::Names;
use crate::scene::Scene;
use crate::view::{Lamp, Shape, View};
use gonio_scene::capture::LightKind;
use std::f64::consts::PI;
use std::fmt::Write;

/// Columns: the axes of a dome's map in a capture's. A dome's map, as OpenEXR says of latitude-longitude maps, has +y on top, its
/// middle column along +z and the quarter to the left of it along +x.
const TO_MAP: Matrix = [[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// The lights of a photo, inside of its variant.
pub fn write(scene: &Scene<'_>, view: &View, out: &mut String) -> std::fmt::Result {
    let mut names = Names::default();
    for lamp in &view.lamps {
        let name = names.identifier(&scene.capture.lights[lamp.light].name);
        write_lamp(lamp, &name, out)?;
    }
    if view.constant != [0.0; 3] {
        let (colour, brightest) = split(view.constant);
        writeln!(out, "                def DomeLight \"{}\"\n                {{", names.identifier("sky"))?;
        writeln!(out, "                    color3f inputs:color = {}", triple(colour))?;
        writeln!(out, "                    float inputs:intensity = {brightest}\n                }}")?;
    }
    if let Some((sky, map)) = view.map.as_ref().and_then(|sky| Some((sky, scene.maps.get(&sky.path)?))) {
        writeln!(out, "                def DomeLight \"{}\"\n                {{", names.identifier("map"))?;
        writeln!(out, "                    float inputs:intensity = {}", sky.scale)?;
        writeln!(out, "                    asset inputs:texture:file = @./{}@", map.file)?;
        writeln!(out, "                    token inputs:texture:format = \"latlong\"")?;
        place(&product(&sky.to_world, &TO_MAP), 5, out)?;
        writeln!(out, "                }}")?;
    }
    Ok(())
}

fn write_lamp(lamp: &Lamp, name: &str, out: &mut String) -> std::fmt::Result {
    let (colour, brightest) = split(lamp.rgb);
    let kind = if matches!(lamp.shape, Shape::Parallel { .. }) { "DistantLight" } else { "SphereLight" };
    let shaped = lamp.lobe.0 > 0.0 && kind == "SphereLight";
    let schemas =
        if shaped { " (\n                    prepend apiSchemas = [\"ShapingAPI\"]\n                )" } else { "" };
    writeln!(out, "                def {kind} \"{name}\"{schemas}\n                {{")?;
    writeln!(out, "                    color3f inputs:color = {}", triple(colour))?;
    let (intensity, to_world) = match &lamp.shape {
        Shape::Parallel { direction } => {
            // Normalised, its intensity is the irradiance on a plane that faces it. It shines along its -z.
            writeln!(out, "                    float inputs:angle = 0\n                    bool inputs:normalize = 1")?;
            (brightest, with_z(direction.map(|x| -x)))
        }
        // Normalised, a sphere's radiance is its intensity over its area 4 pi r^2: so 4 I / normalised is I / (pi r^2).
        Shape::Point { position } => {
            writeln!(out, "                    bool treatAsPoint = 1\n                    bool inputs:normalize = 1")?;
            writeln!(out, "                    float inputs:radius = 0.0001")?;
            (4.0 * brightest, at(*position, lamp))
        }
        Shape::Sphere { position, radius } => {
            writeln!(out, "                    float inputs:radius = {radius}")?;
            (brightest / (PI * radius * radius), at(*position, lamp))
        }
    };
    writeln!(out, "                    float inputs:intensity = {intensity}")?;
    if shaped {
        writeln!(out, "                    float inputs:shaping:focus = {}", lamp.lobe.0)?;
    }
    place(&to_world, 5, out)?;
    writeln!(out, "                }}")
}

/// A place from which a lobe's axis is -z.
fn at(position: [f64; 3], lamp: &Lamp) -> Matrix {
    let mut place = with_z(lamp.lobe.1.map(|x| -x));
    place.iter_mut().zip(position).for_each(|(row, shift)| row[3] = shift);
    place
}

/// A colour whose brightest channel is 1, and its factor.
fn split(rgb: [f64; 3]) -> ([f64; 3], f64) {
    let brightest = rgb.into_iter().fold(0.0, f64::max);
    if brightest > 0.0 { (rgb.map(|c| c / brightest), brightest) } else { ([1.0; 3], 0.0) }
}

/// Judges the lights' numbers.
pub fn judge(scene: &Scene<'_>, ledger: &mut Ledger) {
    for light in &scene.capture.lights {
        let name = format!("light.{}", light.name);
        match light.kind {
            LightKind::Point { .. } => {
                ledger.exact(&name, "a SphereLight with treatAsPoint, normalised: intensity x 4");
            }
            LightKind::Sphere { .. } => ledger.exact(&name, "a SphereLight of its radiance"),
            LightKind::Directional { .. } => ledger.exact(&name, "a DistantLight of angle 0, normalised"),
            LightKind::Map { .. } | LightKind::Constant { .. } => ledger.exact(&name, "a DomeLight"),
        }
        if light.lobe.exponent > 0.0 {
            ledger.exact(&format!("{name}.lobe_exponent"), "inputs:shaping:focus");
            ledger.exact(&format!("{name}.lobe_axis"), "the light's -z");
        }
    }
}
