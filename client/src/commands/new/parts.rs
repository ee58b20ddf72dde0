//! The parts and where they stand.

use super::NewArguments;
use crate::commands::draft::{Place, name_of};
use gonio_calibrate::Part;
use gonio_scene::{SceneError, mesh};

/// Where meshes stand: their origin in the world, metres, and a turn about z, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stand {
    position: [f64; 3],
    degrees: f64,
}

impl Stand {
    /// Reads `X,Y,Z` or `X,Y,Z,DEGREES`.
    ///
    /// # Errors
    /// Other than three or four finite numbers.
    pub fn parse(text: &str) -> Result<Self, String> {
        match numbers(text)[..] {
            [x, y, z] => Ok(Self { position: [x, y, z], degrees: 0.0 }),
            [x, y, z, degrees] => Ok(Self { position: [x, y, z], degrees }),
            _ => Err("write X,Y,Z in metres, or X,Y,Z,DEGREES, such as 0.1,-0.14,0 or 0.1,-0.14,0,90".to_owned()),
        }
    }
}

/// Finite numbers between commas; empty where one is none.
pub(super) fn numbers(text: &str) -> Vec<f64> {
    let all: Option<Vec<f64>> =
        text.split(',').map(|word| word.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    all.unwrap_or_default()
}

/// The parts, with the centre and radius of all, metres.
pub(super) struct Found {
    pub parts: Vec<Part>,
    pub centre: [f64; 3],
    pub radius: f64,
}

/// Reads the meshes.
///
/// # Errors
/// One that is missing or broken.
pub(super) fn read(place: &Place, arguments: &NewArguments) -> Result<Found, SceneError> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let mut meshes = Vec::new();
    for file in &arguments.meshes {
        let relative = place.relative(file)?;
        for position in &mesh::read(&place.files(), &relative)?.positions {
            for (k, &x) in position.iter().enumerate() {
                low[k] = low[k].min(f64::from(x));
                high[k] = high[k].max(f64::from(x));
            }
        }
        meshes.push((name_of(file), relative));
    }
    if meshes.is_empty() {
        return Ok(Found { parts: Vec::new(), centre: [0.0; 3], radius: 0.1 });
    }
    let size = (0..3).map(|k| (high[k] - low[k]) * (high[k] - low[k])).sum::<f64>().sqrt();
    // No part that is photographed on a table is five metres long; one in millimetres is hardly smaller than that.
    let unit = arguments.unit.unwrap_or(if size > 5.0 { 0.001 } else { 1.0 });
    let of_unit = format!("its unit {unit} m (all meshes are {size:.4} units across)");
    let of_place = "the mesh's own frame is the world's; --at says where it stands";
    let guess = match (arguments.at, arguments.unit) {
        (None, None) => format!("{of_place}; {of_unit}"),
        (None, Some(_)) => of_place.to_owned(),
        (Some(_), None) => of_unit,
        (Some(_), Some(_)) => String::new(),
    };
    let stand = arguments.at.unwrap_or(Stand { position: [0.0; 3], degrees: 0.0 });
    let (sin, cos) = libm::sincos(stand.degrees.to_radians());
    let [x, y, z] = stand.position;
    let object_to_world = [
        [unit * cos, 0.0 - unit * sin, 0.0, x],
        [unit * sin, unit * cos, 0.0, y],
        [0.0, 0.0, unit, z],
        [0.0, 0.0, 0.0, 1.0],
    ];
    let part = |(name, mesh)| Part { name, mesh, object_to_world, guess: guess.clone() };
    let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    let centre =
        [0, 1, 2].map(|k| object_to_world[k][3] + (0..3).map(|j| object_to_world[k][j] * middle[j]).sum::<f64>());
    Ok(Found { parts: meshes.into_iter().map(part).collect(), centre, radius: (0.5 * unit * size).max(1e-3) })
}
