//! Alpha and foreground of a pixel from two backdrops.

use super::Backed;
use gonio_scene::SceneError;
use gonio_scene::image::Image;

/// Least distance of two backdrops' colours, of 3 channels 0..1, that tells alpha.
const LEAST_DISTANCE: f32 = 0.06;

/// Refuses backdrops that are alike in most of the image.
pub(super) fn check(backed: &[Backed; 2], plate_a: &Image, plate_b: &Image) -> Result<(), SceneError> {
    let alike = plate_a.pixels.iter().zip(&plate_b.pixels).filter(|(a, b)| squared(a, b) < LEAST_DISTANCE.powi(2));
    let share = alike.count() as f64 / plate_a.pixels.len().max(1) as f64;
    if share <= 0.5 {
        return Ok(());
    }
    let problem = format!("and {} are alike in {:.0} % of the pixels", backed[1].plate_name, 100.0 * share);
    let mend =
        "photograph the part before two backdrops of different colour, such as blue and green, or black and white";
    Err(SceneError::new(&backed[0].plate_name, problem, mend).at("--plate"))
}

fn squared(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum()
}

/// alpha = 1 - (C_a - C_b) . (B_a - B_b) / |B_a - B_b|^2, the least-squares form of Smith and Blinn's equation for theorem
/// 4; the foreground is the mean of C - (1 - alpha) B over both, divided by alpha.
pub(super) fn solve(on: [&Image; 2], plate: [&Image; 2]) -> (Image, Vec<f32>) {
    let count = on[0].pixels.len();
    let (mut pixels, mut alphas) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for k in 0..count {
        let [a, b] = on.map(|image| image.pixels[k]);
        let [back_a, back_b] = plate.map(|image| image.pixels[k]);
        let dot: f32 = (0..3).map(|c| (a[c] - b[c]) * (back_a[c] - back_b[c])).sum();
        // Where the backdrops are alike the difference says nothing, and the floor keeps noise from deciding.
        let alpha = (1.0 - dot / squared(&back_a, &back_b).max(1e-4)).clamp(0.0, 1.0);
        let mixed: [f32; 3] = std::array::from_fn(|c| 0.5 * (a[c] + b[c] - (1.0 - alpha) * (back_a[c] + back_b[c])));
        pixels.push(mixed.map(|value| if alpha > 1e-3 { (value / alpha).clamp(0.0, 1.0) } else { 0.0 }));
        alphas.push(alpha);
    }
    (Image { width: on[0].width, height: on[0].height, pixels }, alphas)
}
