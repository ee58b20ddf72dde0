//! `gonio noise`: read and shot noise from photographs.

use super::{beside, image, write};
use crate::arguments::NoiseArguments;
use crate::failure::Failure;
use crate::output::{tell, tell_error, to_json};
use gonio_prepare::noise::{Curve, Line, Noise, Patch, Photo, blocks, crop, measure, plot};
use gonio_scene::SceneError;
use gonio_scene::image::Image;
use std::path::Path;

/// Pixels of all photos together that are looked at: 400 MB of them.
const PIXELS: u64 = 1 << 25;
/// Flat tiles below which a photo alone says little.
const FEW_TILES: usize = 40;

/// Measures, writes and tells.
///
/// # Errors
/// A photo that is missing or of another size or kind; too little that is flat, or one brightness only.
pub fn run(arguments: &NoiseArguments) -> Result<(), Failure> {
    let mut curve = arguments.response;
    let mut photos = Vec::with_capacity(arguments.photos.len());
    for path in &arguments.photos {
        let name = path.display().to_string();
        let whole = image(path)?;
        let usual = usual(path, &whole);
        let known = *curve.get_or_insert(usual);
        if arguments.response.is_none() && known != usual {
            let problem = format!("is of a kind that is usually {usual}, unlike the photos before it ({known})");
            return Err(SceneError::new(name, problem, "name one kind of files, or say --response").into());
        }
        let part = arguments.patch.unwrap_or_else(|| middle(&whole, arguments.photos.len() as u64));
        if (part.width, part.height) != (whole.width, whole.height) && arguments.patch.is_none() && photos.is_empty() {
            tell_error(&format!(
                "the middle {} x {} pixels are looked at: --patch names others",
                part.width, part.height
            ));
        }
        let bytes = if is_jpeg(path) { std::fs::read(path).ok() } else { None };
        photos.push(Photo {
            image: crop(&name, &whole, part)?,
            name,
            origin: [part.x as usize, part.y as usize],
            blocks: bytes.and_then(|bytes| blocks(&bytes)),
        });
    }
    let curve = curve.unwrap_or(Curve::Linear);
    let noise = measure(&photos, curve, arguments.saturation.unwrap_or(f32::INFINITY))?;
    warn(&noise);
    if let Some(blocks) = photos.first().and_then(|photo| photo.blocks) {
        warn_of_rounding(&noise, blocks.rounding);
    }
    let lines = sensor(&noise, curve, photos.len());
    if let Some(out) = &arguments.out {
        write(out, lines.as_bytes())?;
        write(&beside(out, "svg"), plot(&noise).as_bytes())?;
    }
    if arguments.json {
        return told(arguments, &noise, curve, &lines);
    }
    let bursts = noise.groups.iter().filter(|group| group.len() > 1).count();
    let alone = noise.groups.len() - bursts;
    tell(&format!("{} photos: {bursts} bursts of one scene, {alone} alone; response {curve}", photos.len()));
    for (channel, colour) in noise.channels.iter().zip(["red", "green", "blue"]) {
        tell(&format!("{colour}: in light {}; in the file's values {}", text(&channel.light), text(&channel.file)));
    }
    if noise.shared {
        let each = noise.channels.each_ref().map(|channel| format!("{:.2}", 1.0 / channel.correlation));
        tell(&format!(
            "neighbours are correlated, as by JPEG, demosaicing or a denoiser: 1 pixel is as good as {} independent observations \
             (red, green, blue); the lines say what a mean over many pixels obeys",
            each.join(", ")
        ));
    }
    tell(lines.trim_end());
    if let Some(out) = &arguments.out {
        tell(&format!("{} and {}", out.display(), beside(out, "svg").display()));
    }
    Ok(())
}

/// JPEG's rounding from this part of the noise on makes the figures doubtful: even surfaces have all their blocks rounded alike.
const COARSE: f64 = 0.2;

/// Where JPEG's steps are not small beside the noise.
fn warn_of_rounding(noise: &Noise, rounding: [f64; 3]) {
    for ((channel, rounding), colour) in noise.channels.iter().zip(rounding).zip(["red", "green", "blue"]) {
        let part = rounding / channel.file.variance(0.5).max(f64::MIN_POSITIVE);
        if part > COARSE {
            tell_error(&format!(
                "warning: {colour}: JPEG's rounding is {:.0} % of the noise at half the largest value, so that the figures may be off \
                 by as much: name RAW files, PNG or TIFF, or JPEG with chroma of full size",
                100.0 * part.min(1.0)
            ));
        }
    }
}

/// What is doubtful.
fn warn(noise: &Noise) {
    let [flat, all] = noise.tiles;
    if all > 0 && flat < FEW_TILES && noise.groups.iter().all(|group| group.len() == 1) {
        tell_error(&format!(
            "warning: {flat} of {all} tiles are flat: name a burst of one scene, or a photo of even patches"
        ));
    }
    if noise.groups.iter().all(|group| group.len() == 1) {
        tell_error(
            "warning: there is no burst of one scene: figures of photos alone were up to 22 % off where the truth was known, those of \
             bursts 2 %",
        );
    } else if noise.shared {
        tell_error(
            "warning: neighbours are correlated: figures of JPEG and of smoothed photos were up to 21 % off where the truth was known, \
             those of linear files 2 %",
        );
    }
    if noise.fine {
        tell_error(
            "warning: a photo alone has no flat tile: its noise is taken from differences of neighbours, which is too little \
             where demosaicing or JPEG correlates them: name a burst of one scene",
        );
    }
    for (channel, colour) in noise.channels.iter().zip(["red", "green", "blue"]) {
        let [_, error] = channel.light.errors;
        if error > 0.25 * channel.light.shot && channel.light.shot > 0.0 {
            tell_error(&format!(
                "warning: {colour}: shot noise is known to {:.0} % only: name more photos, or brighter and darker ones",
                100.0 * error / channel.light.shot
            ));
        }
    }
}

/// The lines of a capture's `[sensor]`.
fn sensor(noise: &Noise, curve: Curve, photos: usize) -> String {
    let correlation = noise.channels.iter().map(|channel| channel.correlation).fold(0.0, f64::max);
    let shared = if noise.shared {
        format!(
            "# Neighbours are correlated: up to {correlation:.2} times a pixel's own variance, so that errors come out right.\n"
        )
    } else {
        String::new()
    };
    let Line { read, shot, .. } = noise.sensor;
    format!(
        "# By gonio noise from {photos} photos.\n{shared}[sensor]\n{}read_noise = {}\nshot_noise = {}\n",
        curve.keys(),
        number(read),
        number(shot)
    )
}

/// A number of four digits that TOML reads.
fn number(value: f64) -> String {
    if value == 0.0 { "0.0".to_owned() } else { format!("{value:.3e}") }
}

fn text(line: &Line) -> String {
    let [read, shot] = line.errors;
    format!("read_noise {:.3e} +- {read:.1e}, shot_noise {:.3e} +- {shot:.1e}", line.read, line.shot)
}

fn told(arguments: &NoiseArguments, noise: &Noise, curve: Curve, lines: &str) -> Result<(), Failure> {
    let line = |line: &Line| {
        serde_json::json!({
            "read_noise": line.read, "shot_noise": line.shot,
            "read_noise_error": line.errors[0], "shot_noise_error": line.errors[1],
        })
    };
    let channel = |k: usize| {
        let channel = &noise.channels[k];
        serde_json::json!({
            "light": line(&channel.light), "file": line(&channel.file), "levels": channel.levels.len(),
            "effective_observations_per_pixel": 1.0 / channel.correlation,
        })
    };
    tell(&to_json(&serde_json::json!({
        "photos": arguments.photos.len(), "groups": noise.groups, "response": curve.to_string(),
        "read_noise": noise.sensor.read, "shot_noise": noise.sensor.shot, "sensor": lines,
        "red": channel(0), "green": channel(1), "blue": channel(2),
        "correlated": noise.shared, "neighbours_only": noise.fine, "quantisation_step": noise.step,
        "flat_tiles": noise.tiles[0], "tiles": noise.tiles[1],
        "out": arguments.out.as_ref().map(|out| out.display().to_string()),
    }))?);
    Ok(())
}

fn is_jpeg(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    ending == "jpg" || ending == "jpeg"
}

/// How files of a kind usually hold their values: JPEG and PNG of 8 bits for a display, all others as light.
pub(super) fn usual(path: &Path, image: &Image) -> Curve {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let eight = |value: &f32| (value * 255.0 - (value * 255.0).round()).abs() < 1e-3;
    match ending.to_str().unwrap_or_default() {
        "jpg" | "jpeg" => Curve::Srgb,
        "png" if image.pixels.iter().flatten().all(eight) => Curve::Srgb,
        _ => Curve::Linear,
    }
}

/// As much of the middle of a photo as may be looked at.
fn middle(image: &Image, photos: u64) -> Patch {
    let pixels = u64::from(image.width) * u64::from(image.height) * photos;
    let part = (PIXELS as f64 / pixels as f64).sqrt().min(1.0);
    let [width, height] = [image.width, image.height].map(|side| ((f64::from(side) * part) as u32).clamp(1, side));
    Patch { x: (image.width - width) / 2, y: (image.height - height) / 2, width, height }
}
