//! The light of a new capture.

use super::NewArguments;
use super::parts::numbers;
use crate::commands::draft::Place;
use gonio_calibrate::Draft;
use gonio_scene::SceneError;
use gonio_scene::capture::{Frame, Light, LightKind, Lobe};

/// A lamp that stands still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    position: [f64; 3],
    /// Metres; 0 is a point.
    radius: f64,
}

impl Lamp {
    /// Reads `X,Y,Z` or `X,Y,Z,RADIUS`.
    ///
    /// # Errors
    /// Other than three or four finite numbers, or a radius below 0.
    pub fn parse(text: &str) -> Result<Self, String> {
        match numbers(text)[..] {
            [x, y, z] => Ok(Self { position: [x, y, z], radius: 0.0 }),
            [x, y, z, radius] if radius >= 0.0 => Ok(Self { position: [x, y, z], radius }),
            _ => Err("write X,Y,Z in metres, or X,Y,Z,RADIUS, such as 0.55,0.2,0.7,0.03".to_owned()),
        }
    }

    fn light(self) -> Light {
        let Self { position, radius } = self;
        // What a lamp of one unit sends from 1 m away is of the order of a photo's values; the fit finds it.
        let intensity = [1.0; 3];
        let kind = if radius > 0.0 {
            LightKind::Sphere { position, radius, intensity }
        } else {
            LightKind::Point { position, intensity }
        };
        Light { name: LAMP.to_owned(), frame: Frame::World, kind, lobe: Lobe::default() }
    }
}

const LAMP: &str = "lamp";
const ROOM: &str = "room";
const SKY: &str = "sky";

/// The lights that the arguments name; none where a lamp at the camera is to be guessed.
///
/// # Errors
/// A map that is missing.
pub(super) fn lights(place: &Place, arguments: &NewArguments) -> Result<Vec<Light>, SceneError> {
    let light = |name: &str, kind| Light { name: name.to_owned(), frame: Frame::World, kind, lobe: Lobe::default() };
    if let Some(map) = &arguments.environment {
        return Ok(vec![light(SKY, LightKind::Map { map: place.relative(map)?, scale: 1.0, azimuth: 0.0 })]);
    }
    Ok(arguments.lamp.map(Lamp::light).into_iter().collect())
}

/// Adds the room to lights that are there, and marks what is guessed.
pub(super) fn note(draft: &mut Draft, arguments: &NewArguments) {
    if arguments.environment.is_some() {
        // A scale of 1 has no line of its own.
        draft.guess("[[light]]", SKY, "", "the map's own brightness, scale = 1; free light.sky.scale to fit it");
    }
    if arguments.lamp.is_some() {
        draft.guess("[[light]]", LAMP, "intensity", "one unit; the fit finds it");
    }
    if arguments.room {
        let kind = LightKind::Constant { radiance: [0.05; 3] };
        let room = Light { name: ROOM.to_owned(), frame: Frame::World, kind, lobe: Lobe::default() };
        draft.capture.lights.push(room);
        draft.guess("[[light]]", ROOM, "radiance", "dim, and the same from all sides; the fit finds how bright");
    }
}
