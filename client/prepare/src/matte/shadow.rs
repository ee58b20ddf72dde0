//! Shadows that the part throws on its backdrop.

use gonio_scene::image::Image;

/// Half of the least breadth of a shadow, in pixels: dark hairs are narrower.
const RADIUS: usize = 3;
/// Largest light, multiplied by alpha, that a shadow has of its own.
const OWN_LIGHT: f32 = 0.03;
/// Part of a square of that breadth that has to be dark: noise leaves gaps, and a hair fills a seventh.
const MOST_OF_BOX: f32 = 0.6;
/// Strongest shadow.
const STRONGEST: f32 = 0.85;

/// Sets shadows to background and returns how many pixels they had. A shadow multiplies both backdrops by one number, which
/// is what a black veil does: the two are told apart by breadth alone, so a broad veil of pure black is lost, and a shadow
/// as narrow as a hair stays.
pub(super) fn remove(on: [&Image; 2], plate: [&Image; 2], colour: &mut Image, alpha: &mut [f32]) -> usize {
    let (width, height) = (colour.width as usize, colour.height as usize);
    let dark: Vec<bool> = (0..alpha.len())
        .map(|k| {
            let light = colour.pixels[k].iter().fold(0.0, |most: f32, value| most.max(value * alpha[k]));
            let veiled = (0..2).all(|side| {
                let (seen, back) = (on[side].pixels[k], plate[side].pixels[k]);
                (0..3).all(|c| (seen[c] - (1.0 - alpha[k]) * back[c]).abs() < 0.05)
            });
            (0.015..STRONGEST).contains(&alpha[k]) && light < OWN_LIGHT && veiled
        })
        .collect();
    let least = (MOST_OF_BOX * (2 * RADIUS + 1).pow(2) as f32) as usize;
    let core: Vec<bool> = counts(&dark, width, height, RADIUS).iter().map(|&count| count >= least).collect();
    let reach: Vec<bool> = counts(&core, width, height, RADIUS + 1).iter().map(|&count| count > 0).collect();
    let mut removed = 0;
    for k in (0..alpha.len()).filter(|&k| dark[k] && reach[k]) {
        alpha[k] = 0.0;
        colour.pixels[k] = [0.0; 3];
        removed += 1;
    }
    removed
}

/// How many pixels of the square about each are set.
fn counts(set: &[bool], width: usize, height: usize, radius: usize) -> Vec<usize> {
    let span = |at: usize, count: usize| at.saturating_sub(radius)..(at + radius + 1).min(count);
    let rows: Vec<usize> =
        (0..set.len()).map(|k| span(k % width, width).filter(|x| set[k - k % width + x]).count()).collect();
    (0..set.len()).map(|k| span(k / width, height).map(|y| rows[y * width + k % width]).sum()).collect()
}
