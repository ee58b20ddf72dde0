//! What a calibration found: the capture, the numbers, photo by photo.

use super::CalibrateArguments;
use super::photos::File;
use crate::commands::draft::{Place, name_of};
use crate::failure::Failure;
use crate::output::tell;
use gonio_calibrate::{Calibration, Draft, PhotoFit, Pose, View};
use std::path::Path;

const NAMES: [&str; 9] = ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"];

/// Writes the capture of the photos that count, and tells.
///
/// # Errors
/// A disk that cannot be written to.
pub(super) fn write(
    arguments: &CalibrateArguments,
    place: &Place,
    files: &[File],
    result: &Calibration,
) -> Result<(), Failure> {
    // On the board x goes along the columns, y along the rows and z into it; the world has z up.
    let turn = Pose::new(&[1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0], [0.0; 3]);
    let turn = turn.ok_or_else(|| Failure::Failed("the board's frame is no rotation".to_owned()))?;
    let all: Vec<(&File, &PhotoFit)> = files.iter().zip(&result.photos).collect();
    let used: Vec<&(&File, &PhotoFit)> = all.iter().filter(|(_, photo)| photo.corners > 0).collect();
    let view = |(file, photo): &&(&File, &PhotoFit)| View {
        file: file.relative.clone(),
        camera: result.camera.clone(),
        camera_to_world: turn.after(&photo.board_to_camera.inverse()).matrix(),
    };
    let views: Vec<View> = used.iter().map(view).collect();
    let dir = arguments.out.parent().filter(|dir| !dir.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut draft = Draft::new(&name_of(dir), &views, &[], Vec::new());
    let from = match &arguments.intrinsics {
        Some(file) => format!("given by {}", name_of(file)),
        None => format!("calibrated on a {}", arguments.board.name()),
    };
    draft.note("[camera]", "", "", &format!("{from}: {:.4} px over all corners", result.error));
    for (file, photo) in &used {
        let note = format!("above the board: {:.4} px", photo.error);
        draft.note("[[photo]]", &file.relative, "camera_to_world", &note);
    }
    if !arguments.json {
        told(result, &all);
    }
    place.write(&draft, arguments.json, &object(result, &all))
}

fn values(result: &Calibration) -> [f64; 9] {
    let camera = &result.camera;
    let [k1, k2, p1, p2, k3] = camera.distortion;
    [camera.fx, camera.fy, camera.cx, camera.cy, k1, k2, p1, p2, k3]
}

fn told(result: &Calibration, all: &[(&File, &PhotoFit)]) {
    for ((name, value), error) in NAMES.iter().zip(values(result)).zip(result.errors) {
        // What was not looked for is 0, or as given.
        if error > 0.0 {
            tell(&format!("{name}  {value:12.5}  +- {error:.5}"));
        } else if value != 0.0 {
            tell(&format!("{name}  {value:12.5}"));
        }
    }
    if let Some(left_out) = result.left_out {
        let pixels = if result.model.square { "square pixels" } else { "pixels that are not square" };
        let distortion = result.model.distortion();
        tell(&format!("distortion {distortion}, {pixels}: photos left out are predicted to {left_out:.4} px"));
    }
    for (file, photo) in all.iter().filter(|(_, photo)| photo.corners > 0) {
        let PhotoFit { corners, error, largest, .. } = photo;
        tell(&format!("{}: {corners} corners, {error:.4} px, at most {largest:.4} px", file.at));
    }
    tell(&format!("reprojection error {:.4} px", result.error));
}

fn object(result: &Calibration, all: &[(&File, &PhotoFit)]) -> serde_json::Value {
    let numbers = |values: [f64; 9]| -> serde_json::Map<_, _> {
        NAMES.iter().zip(values).map(|(name, value)| ((*name).to_owned(), serde_json::json!(value))).collect()
    };
    let each = |(file, photo): &(&File, &PhotoFit)| {
        let PhotoFit { corners, error, largest, dropped, .. } = photo;
        let dropped: Vec<_> = dropped.iter().map(|(id, off)| serde_json::json!({ "corner": id, "off": off })).collect();
        serde_json::json!({
            "file": file.at, "corners": corners, "error": error, "largest": largest, "dropped": dropped,
            "left_out": *corners == 0,
        })
    };
    let mut camera = numbers(values(result));
    camera.insert("width".to_owned(), result.camera.width.into());
    camera.insert("height".to_owned(), result.camera.height.into());
    serde_json::json!({
        "camera": camera,
        "errors": numbers(result.errors),
        "error": result.error,
        "distortion": (!result.model.given).then(|| result.model.distortion()),
        "square_pixels": (!result.model.given).then_some(result.model.square),
        "left_out_error": result.left_out,
        "each": all.iter().map(each).collect::<Vec<_>>(),
    })
}
