//! `gonio composite`: the nearest photographed view blended into pictures.

use super::{image, text, write};
use crate::arguments::{CompositeArguments, camera};
use crate::failure::Failure;
use crate::output::{tell, to_json};
use gonio_prepare::composite::{Place, Sprite, composite};
use gonio_prepare::plan::Plan;
use gonio_scene::SceneError;
use gonio_scene::image::{Image, encode_png8};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// Most views kept decoded and scaled.
const KEPT: usize = 16;
/// Longest side of a scaled view, pixels.
const LONGEST: f64 = 16384.0;

/// Draws one frame for every camera.
pub fn run(arguments: &CompositeArguments) -> Result<(), Failure> {
    let plan = Plan::from_json(&arguments.views.display().to_string(), &text(&arguments.views)?)?;
    let cameras = cameras(arguments)?;
    let backgrounds = &arguments.background;
    if backgrounds.len() != 1 && backgrounds.len() != cameras.len() {
        let text = format!(
            "--background: {} pictures for {} cameras: give one, or one for each",
            backgrounds.len(),
            cameras.len()
        );
        return Err(Failure::Input(text));
    }
    if !matches!(arguments.at.len(), 0 | 2) {
        return Err(Failure::Input("--at: write two numbers, X,Y, such as 640,360".to_owned()));
    }
    std::fs::create_dir_all(&arguments.out).map_err(|error| {
        let problem = format!("cannot be created: {error}");
        SceneError::new(arguments.out.display().to_string(), problem, "name a folder that can be written to by --out")
    })?;
    let folder = arguments.views.parent().unwrap_or(Path::new("."));
    let mut sprites: BTreeMap<(usize, u64), Sprite> = BTreeMap::new();
    let mut background = image(&backgrounds[0])?;
    let mut picture = background.clone();
    let mut spent = Duration::ZERO;
    for (k, &[azimuth, elevation, distance]) in cameras.iter().enumerate() {
        if k > 0 && backgrounds.len() > 1 {
            background = image(&backgrounds[k])?;
        }
        let (view, scale) = (plan.nearest(azimuth, elevation), plan.radius / distance);
        let key = (view, scale.to_bits());
        if !sprites.contains_key(&key) {
            if sprites.len() >= KEPT {
                sprites.pop_first();
            }
            let path = folder.join(format!("{}.png", plan.views[view].name));
            sprites.insert(key, sprite(&path, scale)?);
        }
        let Some(sprite) = sprites.get(&key) else { continue };
        let centre = match arguments.at[..] {
            [x, y] => [x, y],
            _ => [i64::from(background.width / 2), i64::from(background.height / 2)],
        };
        let place = Place {
            column: centre[0].saturating_sub(sprite.width as i64 / 2),
            row: centre[1].saturating_sub(sprite.height as i64 / 2),
        };
        let start = Instant::now();
        // The buffer is kept: fresh pages would cost more than the blending.
        (picture.width, picture.height) = (background.width, background.height);
        picture.pixels.clone_from(&background.pixels);
        composite(&mut picture, sprite, place, arguments.method);
        spent += start.elapsed();
        save(&arguments.out.join(format!("frame_{k:04}.png")), &picture)?;
    }
    let milliseconds = 1e3 * spent.as_secs_f64() / cameras.len().max(1) as f64;
    let out = arguments.out.display().to_string();
    if arguments.json {
        let summary = serde_json::json!({ "out": out, "frames": cameras.len(), "blend_milliseconds": milliseconds });
        tell(&to_json(&summary)?);
    } else {
        tell(&format!("{out}: {} frames, {milliseconds:.2} ms each to blend", cameras.len()));
    }
    Ok(())
}

fn cameras(arguments: &CompositeArguments) -> Result<Vec<[f64; 3]>, Failure> {
    let mut cameras = arguments.camera.clone();
    if let Some(path) = &arguments.cameras {
        for (k, line) in text(path)?.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            let found = camera(line).map_err(|mend| {
                SceneError::new(path.display().to_string(), format!("holds \"{line}\""), mend)
                    .at(format!("line {}", k + 1))
            })?;
            cameras.push(found);
        }
    }
    if cameras.is_empty() {
        return Err(Failure::Input("--cameras: the file is empty: write lines AZIMUTH,ELEVATION,DISTANCE".to_owned()));
    }
    Ok(cameras)
}

fn sprite(path: &Path, scale: f64) -> Result<Sprite, Failure> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|error| {
        let mend = "put the view's matte there: <name>.png beside the plan, by `gonio matte`";
        SceneError::new(&name, format!("cannot be read: {error}"), mend)
    })?;
    let sprite = Sprite::decode(&name, &bytes)?;
    if sprite.width.max(sprite.height) as f64 * scale > LONGEST {
        let problem = format!("would be {scale:.1} times as large, more than {LONGEST} pixels");
        return Err(SceneError::new(name, problem, "give a larger distance").at("--camera").into());
    }
    Ok(sprite.scaled(scale))
}

fn save(path: &Path, picture: &Image) -> Result<(), Failure> {
    let code = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    let pixels: Vec<[u8; 3]> = picture.pixels.iter().map(|pixel| pixel.map(code)).collect();
    write(path, &encode_png8(&path.display().to_string(), picture.width, picture.height, &pixels)?)
}
