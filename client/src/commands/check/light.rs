//! Lights and environment maps.

use gonio_scene::capture::{Frame, LightKind};
use gonio_scene::files::Files;
use gonio_scene::{Assets, Capture, SceneError};
use serde::Serialize;

/// One light.
#[derive(Debug, Serialize)]
pub(super) struct LightSummary {
    pub name: String,
    pub kind: &'static str,
    /// "world" or "camera".
    pub frame: &'static str,
    /// Photos in which it is on.
    pub photos: usize,
}

/// Looks at every light and environment map.
pub(super) fn look(
    capture: &Capture,
    files: &dyn Files,
    errors: &mut Vec<SceneError>,
    warnings: &mut Vec<String>,
) -> Vec<LightSummary> {
    for light in &capture.lights {
        if matches!(light.kind, LightKind::Map { .. }) {
            let alone = Capture { lights: vec![light.clone()], ..Capture::default() };
            errors.extend(Assets::load(&alone, files).err());
        }
    }
    for photo in &capture.photos {
        if photo.lights.as_ref().map_or(capture.lights.is_empty(), Vec::is_empty) {
            warnings
                .push(format!("capture.toml: photo.{}.lights: no light is on, so its render is black", photo.name()));
        }
    }
    capture
        .lights
        .iter()
        .map(|light| {
            let is_on = |on: &Option<Vec<String>>| on.as_ref().is_none_or(|on| on.contains(&light.name));
            let photos = capture.photos.iter().filter(|photo| is_on(&photo.lights)).count();
            if photos == 0 {
                warnings.push(format!("capture.toml: light.{} is on in no photo", light.name));
            }
            LightSummary {
                name: light.name.clone(),
                kind: light.kind.word(),
                frame: if light.frame == Frame::Camera { "camera" } else { "world" },
                photos,
            }
        })
        .collect()
}
