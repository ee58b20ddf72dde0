//! `sensor.py`: from a render's light to a photo's values, as `gonio_scene::sensor_stage` says.

use crate::Result;
use crate::files::FileMap;
use crate::ledger::Ledger;
use crate::scene::Scene;
use crate::view::for_each_camera;
use gonio_scene::capture::{Response, Sensor};
use serde_json::{Map, Value, json};

const CODE: &str = include_str!("sensor.py");
const HERE: &str = "sensor.py";

/// The function, with the capture's numbers in it.
///
/// # Errors
/// Numbers that JSON cannot hold.
pub fn files(scene: &Scene<'_>, ledger: &mut Ledger) -> Result<FileMap> {
    judge(scene, ledger);
    // JSON inside of a raw string of Python: no name may end that.
    let data = serde_json::to_string(&data(scene))
        .map_err(|error| crate::ExportError::Json { file: HERE.to_owned(), problem: error.to_string() })?;
    let data = data.replace("\"\"\"", "\\u0022\\u0022\\u0022");
    Ok(FileMap::from([(HERE.to_owned(), CODE.replace("@CAPTURE@", &data).into_bytes())]))
}

fn data(scene: &Scene<'_>) -> Value {
    let sensor = &scene.capture.sensor;
    let (word, curve) = match &sensor.response {
        Response::Linear => ("linear", Value::Null),
        Response::Srgb => ("srgb", Value::Null),
        Response::Curve(curve) => ("curve", json!(curve.tables())),
    };
    let clip = (sensor.clip_level < Sensor::NO_CLIP).then_some(sensor.clip_level);
    let mut photos = Map::new();
    for (view, photo) in scene.views.iter().zip(&scene.capture.photos) {
        let camera = &view.camera;
        let about = json!({
            "width": camera.width, "height": camera.height, "cx": camera.cx, "cy": camera.cy, "factor": photo.factor(),
            "balance": photo.balance,
            "glare_fraction": camera.glare_fraction, "glare_width": camera.glare_width,
        });
        photos.insert(view.name.clone(), about);
    }
    json!({
        "photos": photos,
        "sensor": {
            "vignetting": sensor.vignetting, "crosstalk": sensor.crosstalk, "response": word, "curve": curve,
            "gamma": sensor.gamma, "black_level": sensor.black_level, "clip_level": clip,
            "read_noise": sensor.read_noise, "shot_noise": sensor.shot_noise,
        },
    })
}

fn judge(scene: &Scene<'_>, ledger: &mut Ledger) {
    ledger.exact("sensor", HERE);
    if scene.capture.sensor.saturation.is_some() {
        ledger.lost("sensor.saturation", "says which pixels a fit leaves out, and nothing of a picture");
    }
    for photo in &scene.capture.photos {
        for key in ["exposure", "gain", "balance"] {
            ledger.exact(&format!("photo.{}.{key}", photo.name()), HERE);
        }
    }
    for_each_camera(scene.capture, |name, camera| {
        for key in ["glare_fraction", "glare_width"] {
            let name = format!("{name}.{key}");
            if camera.glare_fraction > 0.0 {
                ledger.approximated(&name, "sensor.py; light from outside of the frame is its border's");
            } else {
                ledger.exact(&name, "not there");
            }
        }
    });
}
