//! `gonio develop`: a RAW file, or another photo, to an image of linear light.

use super::light::{Light, light};
use super::{beside, text, write};
use crate::arguments::DevelopArguments;
use crate::failure::Failure;
use crate::output::{tell, tell_error, to_json};
use gonio_prepare::raw::{Balance, Colour, Developed, Options};
use gonio_scene::SceneError;
use gonio_scene::image::{encode_exr, encode_png8};
use std::path::Path;

/// Develops, writes and tells.
///
/// # Errors
/// A file that cannot be read here, or has not the matrices or the white balance that were asked for.
pub fn run(arguments: &DevelopArguments) -> Result<(), Failure> {
    let matrix = arguments.matrix.as_deref().map(matrix).transpose()?;
    // A chart's matrix is from the camera's own channels.
    let colour = if matrix.is_some() { Colour::Camera } else { arguments.colour };
    let options = Options { demosaic: arguments.demosaic, balance: arguments.white_balance, colour };
    let Light { mut image, clipped, raw } = light(&arguments.photo, arguments.response, options)?;
    if let Some(matrix) = matrix {
        image.pixels.iter_mut().for_each(|pixel| *pixel = times(&matrix, *pixel));
    }
    let out = arguments.out.display().to_string();
    write(&arguments.out, &encode_exr(&out, &image)?)?;
    let counts: Vec<[u8; 3]> = clipped.iter().map(|clipped| [if *clipped { 0 } else { 255 }; 3]).collect();
    write(&beside(&arguments.out, "mask.png"), &encode_png8(&out, image.width, image.height, &counts)?)?;
    let share = clipped.iter().filter(|clipped| **clipped).count() as f64 / clipped.len().max(1) as f64;
    if let Some(raw) = &raw {
        warn(&arguments.photo, raw);
    }
    if arguments.json {
        tell(&to_json(&serde_json::json!({
            "out": out, "width": image.width, "height": image.height, "clipped": share,
            "raw": raw.as_ref().map(|raw| described(raw, options, &arguments.photo)),
        }))?);
        return Ok(());
    }
    let colours = match (arguments.matrix.as_deref(), colour) {
        (Some(file), _) => format!("Rec. 709 by {}", file.display()),
        (None, Colour::Rec709) if raw.is_some() => "Rec. 709 by the camera's matrices".to_owned(),
        (None, Colour::Camera) if raw.is_some() => "the camera's own".to_owned(),
        (None, _) => "the file's own".to_owned(),
    };
    tell(&format!(
        "{out}: {} x {} pixels of linear light; colours: {colours}; {:.2} % clipped, left out in {}",
        image.width,
        image.height,
        100.0 * share,
        beside(&arguments.out, "mask.png").display()
    ));
    if let Some(raw) = &raw {
        tell_raw(raw, options);
    }
    Ok(())
}

fn tell_raw(raw: &Developed, options: Options) {
    let notes = &raw.notes;
    let [black, white] = notes.levels;
    tell(&format!(
        "{} ({}): black {black:.1}, white {white:.0}; matrices from {}",
        notes.camera, notes.format, notes.matrices
    ));
    let gray = raw.neutral.map_or_else(
        || "no white balance is stated".to_owned(),
        |[r, g, b]| format!("as shot, gray was {r:.4},{g:.4},{b:.4} in the camera's channels"),
    );
    let applied = match options.balance {
        Balance::None => "the light keeps its colour (--white-balance as-shot takes it out)",
        Balance::AsShot => "that is white here",
        Balance::Neutral(_) => "what --white-balance says is white here",
    };
    tell(&format!("white balance: {gray}; {applied}"));
    if let Some(exposure) = notes.exposure() {
        tell(&format!("exposure: {exposure:.6} s at f/1 and ISO 100"));
    }
    if let Some([shot, read]) = raw.noise {
        tell(&format!(
            "by the file's NoiseProfile, for gray:\n[sensor]\nread_noise = {:.3e}\nshot_noise = {shot:.3e}",
            read.sqrt()
        ));
    }
}

fn warn(photo: &Path, raw: &Developed) {
    let name = photo.display();
    if (raw.notes.aspect - 1.0).abs() > 0.01 {
        let aspect = raw.notes.aspect;
        tell_error(&format!(
            "warning: {name}: its pixels are {aspect:.3} times as wide as high: fx and fy of its camera differ as much"
        ));
    }
    for left in &raw.notes.left {
        tell_error(&format!("note: {name}: {left}"));
    }
}

/// What a RAW file says, for scripts.
fn described(raw: &Developed, options: Options, photo: &Path) -> serde_json::Value {
    let notes = &raw.notes;
    serde_json::json!({
        "file": photo.display().to_string(), "camera": notes.camera, "format": notes.format,
        "black": notes.levels[0], "white": notes.levels[1], "matrix": raw.matrix, "matrices": notes.matrices,
        "as_shot_neutral": raw.neutral, "white_balance": match options.balance {
            Balance::None => "none".to_owned(),
            Balance::AsShot => "as-shot".to_owned(),
            Balance::Neutral([r, g, b]) => format!("{r},{g},{b}"),
        },
        "exposure_seconds": notes.exposure(), "pixel_aspect": notes.aspect, "opcodes": notes.left,
        "shot_noise": raw.noise.map(|[shot, _]| shot), "read_noise": raw.noise.map(|[_, read]| read.sqrt()),
    })
}

/// The matrix that `gonio chart` wrote.
fn matrix(path: &Path) -> Result<[[f64; 3]; 3], Failure> {
    let name = path.display().to_string();
    let file: serde_json::Value = serde_json::from_str(&text(path)?).unwrap_or_default();
    let rows: Option<[[f64; 3]; 3]> = serde_json::from_value(file["matrix"].clone()).ok();
    let rows = rows.filter(|rows| rows.as_flattened().iter().all(|value| value.is_finite()));
    Ok(rows.ok_or_else(|| {
        SceneError::new(
            name,
            "is no file with three rows of three numbers",
            "name the file that `gonio chart --out` wrote",
        )
        .at("matrix")
    })?)
}

/// A pixel times the matrix.
pub(super) fn times(matrix: &[[f64; 3]; 3], pixel: [f32; 3]) -> [f32; 3] {
    let dot = |row: &[f64; 3]| row.iter().zip(pixel).map(|(a, b)| a * f64::from(b)).sum::<f64>() as f32;
    [dot(&matrix[0]), dot(&matrix[1]), dot(&matrix[2])]
}
