//! `gonio matte`: a silhouette with soft edges from two backdrops.

use super::{image, write};
use crate::arguments::{MatteArguments, colour};
use crate::failure::Failure;
use crate::output::{tell, to_json};
use gonio_prepare::matte::{Backed, Depth, Shadows, encode, matte};
use gonio_scene::image::Image;
use std::path::Path;

/// Solves the matte and writes it.
pub fn run(arguments: &MatteArguments) -> Result<(), Failure> {
    let ([on_a, on_b], [plate_a, plate_b]) = (&arguments.on[..], &arguments.plate[..]) else {
        let text = "--on, --plate: give each twice: two photos of the part, then their two backdrops in the same order";
        return Err(Failure::Input(text.to_owned()));
    };
    let backed = [backed(on_a, plate_a)?, backed(on_b, plate_b)?];
    let shadows = if arguments.keep_shadows { Shadows::Keep } else { Shadows::Remove };
    let mut found = matte(&backed, shadows)?;
    if arguments.binary {
        found.harden();
    }
    let depth = if arguments.depth == 16 { Depth::Sixteen } else { Depth::Eight };
    let out = arguments.out.display().to_string();
    write(&arguments.out, &encode(&out, &found, depth)?)?;
    let covered = found.alpha.iter().map(|&alpha| f64::from(alpha)).sum::<f64>() / found.alpha.len().max(1) as f64;
    if arguments.json {
        tell(&to_json(&serde_json::json!({
            "out": out, "covered": covered, "shadow_pixels": found.shadow,
            "gain": found.drift.map(|drift| drift.gain),
        }))?);
    } else {
        let gains = found.drift.map(|drift| drift.gain.map(|gain| format!("{gain:.3}")).join("/"));
        tell(&format!(
            "{out}: {:.1} % covered; {} pixels of shadow; gain over the backdrop {} and {}",
            100.0 * covered,
            found.shadow,
            gains[0],
            gains[1]
        ));
    }
    Ok(())
}

/// A photo with its backdrop: a file, or a colour.
fn backed(on: &Path, plate: &str) -> Result<Backed, Failure> {
    let photo = image(on)?;
    let backdrop = if plate.starts_with('#') {
        let colour = colour(plate).map_err(|mend| Failure::Input(format!("--plate: {plate}: {mend}")))?;
        let pixel = colour.map(|value| f32::from(value) / 255.0);
        Image { width: photo.width, height: photo.height, pixels: vec![pixel; photo.pixels.len()] }
    } else {
        image(Path::new(plate))?
    };
    Ok(Backed { name: on.display().to_string(), on: photo, plate_name: plate.to_owned(), plate: backdrop })
}
