//! `gonio chart`: a camera's colour matrix from a photo of a chart of 24 patches.

use super::develop::times;
use super::light::{Light, light};
use super::write;
use crate::arguments::ChartArguments;
use crate::failure::Failure;
use crate::output::{tell, to_json, to_pretty_json};
use gonio_prepare::chart::{Found, fit};
use gonio_prepare::raw::{Colour, Options};
use gonio_scene::image::encode_exr;

/// Fits, writes and tells.
///
/// # Errors
/// Corners that are not the chart's, in a wrong order, or too many saturated patches.
pub fn run(arguments: &ChartArguments) -> Result<(), Failure> {
    let options = Options { colour: Colour::Camera, ..Options::default() };
    let Light { mut image, mut clipped, raw } = light(&arguments.photo, arguments.response, options)?;
    if let Some(limit) = arguments.saturation {
        clipped = image.pixels.iter().map(|pixel| pixel.iter().any(|value| *value >= limit)).collect();
    }
    let name = arguments.photo.display().to_string();
    let found = fit(&name, &image, &clipped, arguments.corners, arguments.edition)?;
    let matrix = [0, 1, 2].map(|row| [0, 1, 2].map(|column| found.matrix[(row, column)]));
    let result = described(arguments, &found, &matrix, raw.is_some());
    if let Some(out) = &arguments.out {
        write(out, to_pretty_json(&result)?.as_bytes())?;
    }
    if let Some(out) = &arguments.apply {
        image.pixels.iter_mut().for_each(|pixel| *pixel = times(&matrix, *pixel));
        write(out, &encode_exr(&out.display().to_string(), &image)?)?;
    }
    if arguments.json {
        tell(&to_json(&result)?);
        return Ok(());
    }
    tell("patch            before   after  dE2000");
    for patch in &found.patches {
        let note = if patch.saturated { "  saturated: left out" } else { "" };
        tell(&format!("{:15} {:7.2} {:7.2}{note}", patch.name, patch.before, patch.after));
    }
    let [before, after] = found.mean;
    tell(&format!("{:15} {before:7.2} {after:7.2}", "mean"));
    tell(&format!("exposure {:.4}; matrix from the photo's linear values to Rec. 709, white 1:", found.exposure));
    for [r, g, b] in matrix {
        tell(&format!("  {r:9.5} {g:9.5} {b:9.5}"));
    }
    for out in arguments.out.iter().chain(&arguments.apply) {
        tell(&out.display().to_string());
    }
    Ok(())
}

fn described(arguments: &ChartArguments, found: &Found, matrix: &[[f64; 3]; 3], raw: bool) -> serde_json::Value {
    let patch = |patch: &gonio_prepare::chart::Patch| {
        serde_json::json!({
            "name": patch.name, "lab": patch.lab, "before": patch.before, "after": patch.after, "saturated": patch.saturated,
        })
    };
    serde_json::json!({
        "photo": arguments.photo.display().to_string(), "matrix": matrix, "exposure": found.exposure,
        "from": if raw { "the camera's channels, linear, over the white level" } else { "the photo's values, linear" },
        "mean_before": found.mean[0], "mean_after": found.mean[1],
        "patches": found.patches.iter().map(patch).collect::<Vec<_>>(),
    })
}
