//! What a new capture needs to be fitted at once: free numbers, photos that are kept back, the sensor's noise.

use gonio_calibrate::Draft;
use gonio_scene::capture::{Frame, LightKind, Model, Role};

/// One photo of so many judges the fit, and none of fewer than [`FEWEST`].
const EACH: usize = 6;
/// Below five photos each is worth more to the fit than to its judge.
const FEWEST: usize = 5;

/// Standard deviation of a black pixel, in photo values: half a step of 8 bits.
const READ_NOISE: f64 = 0.002;
/// Variance for each unit of a photo value: 2,500 electrons at white, as many as a small sensor's pixel holds.
const SHOT_NOISE: f64 = 0.0004;

/// Completes the draft.
pub(super) fn complete(draft: &mut Draft) {
    let capture = &mut draft.capture;
    let mut free = Vec::new();
    for material in &capture.materials {
        let name = format!("material.{}", material.name);
        // Other materials than the parts' are known.
        if matches!(material.model, Model::Plastic { .. }) {
            free.extend([format!("{name}.base_color"), format!("{name}.roughness")]);
        }
    }
    for light in &capture.lights {
        let name = format!("light.{}", light.name);
        match &light.kind {
            LightKind::Map { .. } => free.push(format!("{name}.scale")),
            LightKind::Constant { .. } => free.push(format!("{name}.radiance")),
            LightKind::Directional { .. } => free.push(format!("{name}.irradiance")),
            LightKind::Point { .. } | LightKind::Sphere { .. } => free.push(format!("{name}.intensity")),
        }
        // A lamp at the camera is a guess of another kind: where it is, nobody measured.
        let still = light.frame == Frame::World;
        if still && matches!(light.kind, LightKind::Point { .. } | LightKind::Sphere { .. }) {
            free.push(format!("{name}.position"));
        }
    }
    if !capture.objects.is_empty() {
        capture.fit.parameters = free;
        let text = "what is free; `gonio check --names` lists what else could be";
        draft.guess("[fit]", "", "parameters", text);
    }
    hold_out(draft);
    let sensor = &mut draft.capture.sensor;
    if sensor.read_noise == 0.0 && sensor.shot_noise == 0.0 {
        (sensor.read_noise, sensor.shot_noise) = (READ_NOISE, SHOT_NOISE);
        let text = "the noise of a small camera; stated errors scale with it, so measure it on an even surface";
        draft.guess("[sensor]", "", "read_noise", text);
    }
}

/// Keeps photos back for the judge.
fn hold_out(draft: &mut Draft) {
    let count = draft.capture.photos.len();
    if count < FEWEST {
        return;
    }
    for index in (EACH.min(count) - 1..count).step_by(EACH) {
        let photo = &mut draft.capture.photos[index];
        photo.role = Role::HeldOut;
        let file = photo.file.clone();
        draft.note("[[photo]]", &file, "role", "Judges the fit, which never reads it before its last step.");
    }
}
