//! From photos to lines.

use super::burst::{self, Frames};
use super::{Blocks, Curve, Level, Line, single};
use gonio_scene::SceneError;
use gonio_scene::image::Image;

/// A photo and its name for messages.
#[derive(Debug)]
pub struct Photo {
    /// The file's name.
    pub name: String,
    /// Its values, or those of a part.
    pub image: Image,
    /// Column and row of the part's upper left pixel.
    pub origin: [usize; 2],
    /// How it is coded, of a JPEG.
    pub blocks: Option<Blocks>,
}

/// A channel's noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// The line in light, without what rounding to the file's steps adds.
    pub light: Line,
    /// The line in the file's own values.
    pub file: Line,
    /// The noise of a mean over many pixels over that of as many independent ones: 1 where no neighbours are correlated.
    pub correlation: f64,
    /// What the line in light was fitted to.
    pub levels: Vec<Level>,
}

/// A camera's noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// Red, green, blue.
    pub channels: [Channel; 3],
    /// One line for all channels in the file's own values: what a capture's `[sensor]` states.
    pub sensor: Line,
    /// The step between neighbouring values of the files; 0 for floats and 16 bits.
    pub step: f64,
    /// Whether the lines are those of the noise that neighbours share.
    pub shared: bool,
    /// Groups of photos that show one scene, by index; a photo alone was searched for flat tiles.
    pub groups: Vec<Vec<usize>>,
    /// Of the photos alone, tiles that were flat, and tiles that there were.
    pub tiles: [usize; 2],
    /// Whether a photo alone has no flat tile: its noise is that of neighbours' differences, which is too small where
    /// neighbours are correlated.
    pub fine: bool,
}

/// Photos whose means differ by less show the same light.
const SAME_LIGHT: f64 = 0.03;
/// Neighbours are correlated where a mean over many pixels has this much more noise, or this much less, than independent ones.
const CORRELATED: [f64; 2] = [0.85, 1.15];
/// A value up to this part of the largest is not clipped.
const UNCLIPPED: f32 = 0.98;
/// Fewest levels of a channel.
const FEWEST: usize = 3;
/// Least ratio of the brightest level to the darkest.
const SPAN: f64 = 1.5;

/// Measures the noise. Pixels at or above `saturation`, or at 0 or below, do not count.
///
/// # Errors
/// Photos of different sizes; too few flat or unclipped pixels; one brightness only.
pub fn measure(photos: &[Photo], curve: Curve, saturation: f32) -> Result<Noise, SceneError> {
    let Some(first) = photos.first() else {
        return Err(SceneError::new("PHOTOS", "names no photo", "name a photo, or a burst of one scene"));
    };
    let (width, height) = (first.image.width, first.image.height);
    if let Some(other) = photos.iter().find(|photo| (photo.image.width, photo.image.height) != (width, height)) {
        let problem =
            format!("is {} x {} pixels, {} is {width} x {height}", other.image.width, other.image.height, first.name);
        return Err(SceneError::new(&other.name, problem, "name photos of one size"));
    }
    let width = width as usize;
    let groups = groups(photos, width, saturation);
    // One camera's photos are coded alike; else the first's blocks would be others' halves.
    let coded = first.blocks.filter(|blocks| photos.iter().all(|photo| photo.blocks == Some(*blocks)));
    let step = photos.iter().map(|photo| step(&photo.image)).fold(0.0, f64::max);
    let (mut tiles, mut fine) = ([0, 0], false);
    let mut found: [[Vec<Level>; 2]; 3] = Default::default();
    for (c, [in_light, in_file]) in found.iter_mut().enumerate() {
        for group in &groups {
            let usable = usable(photos, group, c, saturation);
            let values = |of: &dyn Fn(f64) -> f64| -> Vec<Vec<f32>> {
                let plane =
                    |&k: &usize| photos[k].image.pixels.iter().map(|pixel| of(f64::from(pixel[c])) as f32).collect();
                group.iter().map(plane).collect()
            };
            for (levels, planes) in
                [(&mut *in_light, values(&|value| curve.light(value))), (&mut *in_file, values(&|value| value))]
            {
                if let [plane] = &planes[..] {
                    let found = single::levels(plane, width, &usable);
                    tiles = [tiles[0] + found.flat.len(), tiles[1] + found.tiles];
                    fine |= found.fine;
                    levels.extend(found.flat);
                    continue;
                }
                let frames = Frames { width, frames: &planes, usable: &usable };
                levels.extend(match coded {
                    Some(blocks) => burst::block_levels(&frames, blocks.side, photos[group[0]].origin),
                    None => burst::levels(&frames),
                });
            }
        }
        unround(in_light, step, coded.map_or(0.0, |blocks| blocks.rounding[c]), curve);
    }
    check(&first.name, photos.len(), &found)?;
    let correlations = [0, 1, 2].map(|c| correlation(&found[c][0]));
    let shared = correlations.iter().any(|found| !(CORRELATED[0]..=CORRELATED[1]).contains(found));
    let of = |level: &Level| if shared { level.shared } else { level.variance };
    let line = |levels: &[Level]| {
        Line::through(levels, of).ok_or_else(|| {
            let problem = "shows too little noise, or too few brightnesses, for a line of variance over mean";
            SceneError::new(&first.name, problem, "name photos that were not denoised, of bright and of dark surfaces")
        })
    };
    let sensor = line(&found.iter().flat_map(|[_, in_file]| in_file.clone()).collect::<Vec<_>>())?;
    let mut channels = Vec::with_capacity(3);
    for ([in_light, in_file], correlation) in found.into_iter().zip(correlations) {
        channels.push(Channel { light: line(&in_light)?, file: line(&in_file)?, correlation, levels: in_light });
    }
    let channels = <[Channel; 3]>::try_from(channels)
        .map_err(|_| SceneError::new(&first.name, "has not three channels", "name colour photos"))?;
    // Every tile was counted in three channels, in light and as the file has it.
    Ok(Noise { channels, sensor, step, shared, groups, tiles: tiles.map(|count| count / 6), fine })
}

fn check(name: &str, photos: usize, found: &[[Vec<Level>; 2]; 3]) -> Result<(), SceneError> {
    for ([levels, _], colour) in found.iter().zip(["red", "green", "blue"]) {
        if levels.len() < FEWEST {
            let problem = format!(
                "and {} more give too few flat pixels in {colour} that are neither dark nor clipped",
                photos - 1
            );
            let mend = "name several photos of one still scene from a tripod, or one of large even patches";
            return Err(SceneError::new(name, problem, mend));
        }
        let (low, high) =
            levels.iter().fold((f64::MAX, 0.0_f64), |(low, high), level| (low.min(level.mean), high.max(level.mean)));
        if high < SPAN * low {
            let deviation = (levels.iter().map(|level| level.variance).sum::<f64>() / levels.len() as f64).sqrt();
            let problem = format!(
                "shows one brightness in {colour} ({low:.4} to {high:.4} in light, standard deviation {deviation:.2e}), which \
                 does not tell shot noise from read noise"
            );
            let mend = "add photos that are darker or brighter, by exposure or lamp, or of a scene with dark and bright surfaces";
            return Err(SceneError::new(name, problem, mend));
        }
    }
    Ok(())
}

/// How much more noise a mean over many pixels has: that of the middle level, which no odd tile moves.
fn correlation(levels: &[Level]) -> f64 {
    let mut ratios: Vec<f64> = levels.iter().map(|level| level.shared / level.variance).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied().unwrap_or(1.0)
}

/// Takes out what rounding to steps adds to a variance: a twelfth of the step's square (Sheppard's correction), and what JPEG's
/// rounding, `coded` in the file's values squared, adds to what neighbours share; seen in light.
fn unround(levels: &mut [Level], step: f64, coded: f64, curve: Curve) {
    for level in levels {
        // The file's value of the mean, by halving: curves rise.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if curve.light(middle) < level.mean { low = middle } else { high = middle }
        }
        let rounded = (curve.slope(low) * step) * (curve.slope(low) * step) / 12.0;
        // What is left is never less than a hundredth: a variance of 0 would have no weight.
        let coded = curve.slope(low) * curve.slope(low) * coded;
        level.shared = (level.shared - rounded - coded).max(0.01 * level.shared.abs());
        level.variance = (level.variance - rounded).max(0.01 * level.variance);
    }
}

/// 1/255 where all values are multiples of it, else 0: the steps of 16 bits are below any sensor's noise.
fn step(image: &Image) -> f64 {
    let multiple = |value: &f32| (value * 255.0 - (value * 255.0).round()).abs() < 1e-3;
    if image.pixels.iter().flatten().all(multiple) { 1.0 / 255.0 } else { 0.0 }
}

fn usable(photos: &[Photo], group: &[usize], channel: usize, saturation: f32) -> Vec<bool> {
    let most = photos.iter().flat_map(|photo| &photo.image.pixels).flatten().fold(0.0_f32, |a, b| a.max(*b));
    // A file's largest value is where its sensor or its format ends, unless it is far from both.
    let limit = saturation.min(if most >= 0.9 { UNCLIPPED * most } else { f32::MAX });
    let good = |k: usize| {
        group.iter().all(|&photo| {
            let value = photos[photo].image.pixels[k][channel];
            value > 0.0 && value < limit
        })
    };
    (0..photos[group[0]].image.pixels.len()).map(good).collect()
}

/// Photos that show one scene in one light together, the others alone.
fn groups(photos: &[Photo], width: usize, saturation: f32) -> Vec<Vec<usize>> {
    let green = |k: usize| -> Vec<f32> { photos[k].image.pixels.iter().map(|pixel| pixel[1]).collect() };
    let mean = |values: &[f32]| values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len().max(1) as f64;
    let mut groups: Vec<(Vec<usize>, Vec<f32>)> = Vec::new();
    for k in 0..photos.len() {
        let values = green(k);
        let same = groups.iter_mut().find(|(group, first)| {
            let (a, b) = (mean(first), mean(&values));
            (a - b).abs() <= SAME_LIGHT * a.max(b)
                && burst::is_one_scene(first, &values, width, &usable(photos, &[group[0], k], 1, saturation))
        });
        match same {
            Some((group, _)) => group.push(k),
            None => groups.push((vec![k], values)),
        }
    }
    groups.into_iter().map(|(group, _)| group).collect()
}
