//! `gonio hdr`: a radiance map from a stack of exposures.

use super::light::raw;
use super::{beside, image, text, write};
use crate::arguments::HdrArguments;
use crate::failure::Failure;
use crate::output::{tell, tell_error, to_json};
use gonio_prepare::hdr::{
    Mark, Merged, Orientation, Response, Shot, Stack, align, calibrate, correct_times, exposure, fill_below, merge,
    orient, plot, preview,
};
use gonio_prepare::raw::Options;
use gonio_scene::SceneError;
use gonio_scene::image::{encode_exr, encode_png8, is_raw};
use std::collections::BTreeMap;
use std::path::Path;

/// Merges the photos and writes map, response, plot, preview and marks.
pub fn run(arguments: &HdrArguments) -> Result<(), Failure> {
    let orientation = orientation(arguments)?;
    let known = arguments.response.as_deref().map(response).transpose()?;
    let mut stack = Stack::new(shots(arguments)?, arguments.exclude)?;
    if arguments.align {
        let shifts = align::shifts(&stack);
        stack.shift(&shifts);
    }
    let suspects = correct_times(&mut stack, arguments.region, known.as_ref());
    for suspect in &suspects {
        tell_error(&format!(
            "warning: {}: an exposure of {:.4} s contradicts the other photos, which say {:.4} s: that is used; \
             correct it in --times",
            suspect.name, suspect.given, suspect.found
        ));
    }
    let learnt = match known {
        Some(response) => response,
        None => calibrate(&stack, arguments.region)?,
    };
    let mut merged = merge(&stack, &learnt);
    for (name, mark) in &merged.useless {
        let how = if *mark == Mark::Saturated { "saturated" } else { "black" };
        tell_error(&format!("warning: {name}: is {how} throughout, and adds nothing"));
    }
    let out = arguments.out.display().to_string();
    let marks = marks(&merged);
    let (width, height) = (merged.radiance.width, merged.radiance.height);
    if orientation != Orientation::default() {
        merged.radiance = orient(&out, &merged.radiance, orientation)?;
    }
    if let Some(degrees) = arguments.fill_below {
        fill_below(&out, &mut merged.radiance, degrees)?;
    }
    write(&arguments.out, &encode_exr(&out, &merged.radiance)?)?;
    write(&beside(&arguments.out, "response.json"), learnt.to_json().as_bytes())?;
    write(&beside(&arguments.out, "response.svg"), plot(&learnt).as_bytes())?;
    let shown = encode_png8(&out, width, height, &preview(&merged.radiance))?;
    write(&beside(&arguments.out, "preview.png"), &shown)?;
    write(&beside(&arguments.out, "marks.png"), &encode_png8(&out, width, height, &marks)?)?;
    summarise(arguments, &merged, stack.shots().len(), suspects.len())
}

fn summarise(arguments: &HdrArguments, merged: &Merged, shots: usize, corrected: usize) -> Result<(), Failure> {
    let share = |mark: Mark| {
        let count = merged.marks.iter().filter(|&&found| found == mark).count();
        100.0 * count as f64 / merged.marks.len().max(1) as f64
    };
    let out = arguments.out.display().to_string();
    let (width, height) = (merged.radiance.width, merged.radiance.height);
    let [moved, dark, saturated] = [Mark::Moved, Mark::Dark, Mark::Saturated].map(share);
    if arguments.json {
        tell(&to_json(&serde_json::json!({
            "out": out, "width": width, "height": height, "photos": shots, "corrected_times": corrected,
            "percent_moved": moved, "percent_dark": dark, "percent_saturated": saturated,
        }))?);
    } else {
        tell(&format!(
            "{out}: {width} x {height} pixels from {shots} photos; {moved:.1} % with a photo left out, \
             {saturated:.1} % saturated and {dark:.1} % dark in all"
        ));
    }
    Ok(())
}

/// What is red is saturated, blue dark, green has a photo left out, gray lies outside of every frame; black is good. As
/// the photos lie: before any turn.
fn marks(merged: &Merged) -> Vec<[u8; 3]> {
    let colour = |mark: &Mark| match mark {
        Mark::Good => [0, 0, 0],
        Mark::Moved => [0, 160, 0],
        Mark::Dark => [0, 0, 255],
        Mark::Saturated => [255, 0, 0],
        Mark::Outside => [128, 128, 128],
    };
    merged.marks.iter().map(colour).collect()
}

fn orientation(arguments: &HdrArguments) -> Result<Orientation, Failure> {
    let (pitch, roll) = match arguments.level[..] {
        [] => (0.0, 0.0),
        [pitch, roll] => (pitch, roll),
        _ => return Err(Failure::Input("--level: write two numbers, PITCH,ROLL, such as 2.5,-1".to_owned())),
    };
    if ![arguments.turn, pitch, roll].iter().all(|angle| angle.is_finite()) {
        return Err(Failure::Input("--turn, --level: write finite numbers of degrees".to_owned()));
    }
    Ok(Orientation { turn: arguments.turn, pitch, roll })
}

fn response(path: &Path) -> Result<Response, Failure> {
    Ok(Response::from_json(&path.display().to_string(), &text(path)?)?)
}

fn shots(arguments: &HdrArguments) -> Result<Vec<Shot>, Failure> {
    let times = arguments.times.as_deref().map(times).transpose()?.unwrap_or_default();
    let mut shots = Vec::with_capacity(arguments.photos.len());
    for path in &arguments.photos {
        let name = path.display().to_string();
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let listed = times.get(&name).or_else(|| times.get(&file));
        if is_raw(path) {
            let raw = raw(path, Options::default())?;
            let seconds = listed.copied().or_else(|| raw.notes.exposure()).ok_or_else(|| {
                let mend = "write its time into a list `file,seconds`, and name the list by --times";
                SceneError::new(&name, "states no exposure time", mend).at("ExposureTime")
            })?;
            shots.push(Shot { image: raw.image, name, seconds });
            continue;
        }
        let seconds = match listed {
            Some(&seconds) => seconds,
            None => {
                let bytes = std::fs::read(path).map_err(|error| {
                    SceneError::new(&name, format!("cannot be read: {error}"), "correct the path, or its permissions")
                })?;
                exposure(&name, &bytes)?
            }
        };
        shots.push(Shot { image: image(path)?, name, seconds });
    }
    Ok(shots)
}

/// Exposure times by file; a heading and empty lines are passed over.
fn times(path: &Path) -> Result<BTreeMap<String, f64>, Failure> {
    let mut times = BTreeMap::new();
    for (k, line) in text(path)?.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') || (k == 0 && line.replace(' ', "") == "file,seconds") {
            continue;
        }
        let entry = line.rsplit_once(',').and_then(|(file, time)| {
            let seconds = match time.trim().split_once('/') {
                Some((over, under)) => over.trim().parse::<f64>().ok()? / under.trim().parse::<f64>().ok()?,
                None => time.trim().parse().ok()?,
            };
            Some((file.trim().to_owned(), seconds))
        });
        let Some((file, seconds)) = entry else {
            let error = SceneError::new(
                path.display().to_string(),
                format!("holds \"{line}\""),
                "write lines `file,seconds`, such as img_1.jpg,0.5 or img_1.jpg,1/60",
            );
            return Err(error.at(format!("line {}", k + 1)).into());
        };
        times.insert(file, seconds);
    }
    Ok(times)
}
