//! Shadows that the part throws on its backdrop.

use gonio_scene::image::Image;

/// Half of the least breadth of a shadow, in pixels: dark hairs are narrower.
const RADIUS: usize = 3;
/// Largest light, multiplied by alpha, that a shadow has of its own.
const OWN_LIGHT: f32 = 0.03;
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
    let core = box_all(&dark, width, height);
    let reach = box_any(&core, width, height);
    let mut removed = 0;
    for k in (0..alpha.len()).filter(|&k| dark[k] && reach[k]) {
        alpha[k] = 0.0;
        colour.pixels[k] = [0.0; 3];
        removed += 1;
    }
    removed
}

/// Whether all pixels of the square about each are set.
fn box_all(set: &[bool], width: usize, height: usize) -> Vec<bool> {
    let unset: Vec<bool> = set.iter().map(|set| !set).collect();
    grown(&unset, width, height, RADIUS).iter().map(|set| !set).collect()
}

/// Whether any pixel of the square about each is set, one further than [`box_all`] looks.
fn box_any(set: &[bool], width: usize, height: usize) -> Vec<bool> {
    grown(set, width, height, RADIUS + 1)
}

fn grown(set: &[bool], width: usize, height: usize, radius: usize) -> Vec<bool> {
    let along = |set: &[bool], count: usize, step: usize, k: usize, at: usize| {
        let (from, to) = (at.saturating_sub(radius), (at + radius).min(count - 1));
        (from..=to).any(|other| set[k + other * step - at * step])
    };
    let rows: Vec<bool> = (0..set.len()).map(|k| along(set, width, 1, k, k % width)).collect();
    (0..set.len()).map(|k| along(&rows, height, width, k, k / width)).collect()
}
