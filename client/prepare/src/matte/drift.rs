//! Exposure and colour balance that changed between a photo and its backdrop.

use super::Backed;
use super::triangulate;
use gonio_scene::SceneError;
use gonio_scene::image::Image;

/// Largest drift in ln(gain): a factor of two.
const LARGEST: f64 = 0.7;
/// Bins of a histogram of ln(gain), of a thousandth each; channels may drift apart by twice the largest drift.
const BINS: usize = 2801;
const BIN: f64 = 0.001;
/// A code of an 8-bit file: its rounding and noise.
const CODE: f64 = 1.0 / 255.0;
/// Least value of a backdrop whose ratio to a photo says something.
const DARKEST: f32 = 0.04;
/// Smallest part of a photo that has to show its backdrop.
const SMALLEST_SHARE: f64 = 0.03;

/// Gain of a photo over its backdrop, for red, green, blue; 1 is none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drift {
    /// Photo = gain * backdrop, where the backdrop shows.
    pub gain: [f32; 3],
}

/// Which image drifted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// The photos agree with each other: the plates are brought to them.
    Plates,
    /// The photos differ by their drifts: they are brought to the plates.
    Photos,
}

/// The gain that most pixels share. A shadow darkens all channels alike: the balance of the channels is the commonest of
/// their ratios, in shadow or out of it, and the exposure the commonest of what is left. Shadows lie below the exposure in
/// close succession, so a mean, however robust, would be pulled down; the kernel of the mode is as wide as a code is. A
/// drift of less than half a code over the backdrop cannot be told from rounding, and is none.
pub(super) fn estimate(backed: &Backed) -> Result<Drift, SceneError> {
    let pairs = || backed.on.pixels.iter().zip(&backed.plate.pixels);
    let count = backed.on.pixels.len().max(1) as f64;
    let mean: [f64; 3] = std::array::from_fn(|c| pairs().map(|(_, plate)| f64::from(plate[c])).sum::<f64>() / count);
    // A channel that the backdrop lacks keeps its gain: nothing there depends on it.
    let mut present: Vec<usize> = (0..3).filter(|&c| mean[c] > f64::from(DARKEST)).collect();
    present.sort_by(|&a, &b| mean[b].total_cmp(&mean[a]));
    let mut gain = [1.0_f32; 3];
    if let Some(&base) = present.first() {
        let width = CODE * present.len() as f64 / present.iter().map(|&c| mean[c]).sum::<f64>();
        let usable = |on: &[f32; 3], plate: &[f32; 3]| {
            present.iter().all(|&c| plate[c] > DARKEST && on[c] > 0.5 * DARKEST && on[c] < 0.99)
        };
        let ratios: Vec<([f64; 3], f64)> = pairs()
            .filter(|(on, plate)| usable(on, plate))
            // Dark pixels have coarse ratios.
            .map(|(on, plate)| ([0, 1, 2].map(|c| libm::log(f64::from(on[c] / plate[c]))), f64::from(plate[base])))
            .collect();
        let mut balance = [0.0; 3];
        for &c in &present[1..] {
            balance[c] = mode(ratios.iter().map(|(log, weight)| (log[c] - log[base], *weight)), width);
        }
        let shade = |log: &[f64; 3]| present.iter().map(|&c| log[c] - balance[c]).sum::<f64>() / present.len() as f64;
        let exposure = mode(ratios.iter().map(|(log, weight)| (shade(log), *weight)), width);
        for &c in &present {
            let found = libm::exp((exposure + balance[c]).clamp(-LARGEST, LARGEST));
            if (found - 1.0).abs() * mean[c] > 0.5 * CODE {
                gain[c] = found as f32;
            }
        }
    }
    let near = |(on, plate): &(&[f32; 3], &[f32; 3])| (0..3).all(|c| (on[c] - gain[c] * plate[c]).abs() < 0.05);
    let share = pairs().filter(near).count() as f64 / backed.on.pixels.len().max(1) as f64;
    if share < SMALLEST_SHARE {
        let problem = format!("shows its backdrop {} in {:.1} % of its pixels", backed.plate_name, 100.0 * share);
        let mend =
            "give --plate in the order of --on, photographed from the same place, and leave backdrop around the part";
        return Err(SceneError::new(&backed.name, problem, mend).at("--plate"));
    }
    Ok(Drift { gain })
}

/// The commonest of weighted values: the peak of their density under a Gaussian kernel of standard deviation `width`; 0
/// where there are none.
fn mode(values: impl Iterator<Item = (f64, f64)>, width: f64) -> f64 {
    let middle = (BINS / 2) as f64;
    let mut bins = vec![0.0_f64; BINS];
    for (value, weight) in values {
        let place = (value / BIN + middle).round();
        if place >= 0.0 && place < BINS as f64 {
            bins[place as usize] += weight;
        }
    }
    let width = (width / BIN).clamp(1.0, middle / 6.0);
    let reach = (3.0 * width) as usize;
    let kernel: Vec<f64> =
        (0..=2 * reach).map(|k| libm::exp(-0.5 * ((k as f64 - reach as f64) / width).powi(2))).collect();
    let density = |bin: usize| {
        let first = bin.saturating_sub(reach);
        let last = (bin + reach).min(BINS - 1);
        (first..=last).map(|k| bins[k] * kernel[k + reach - bin]).sum::<f64>()
    };
    let mut best = (0.0, BINS / 2);
    for bin in 0..BINS {
        let found = density(bin);
        if found > best.0 {
            best = (found, bin);
        }
    }
    (best.1 as f64 - middle) * BIN
}

/// Which side to correct: what is opaque has one colour in both photos.
pub(super) fn side(backed: &[Backed; 2], drift: &[Drift; 2]) -> Side {
    let [a, b] = backed;
    let plates = [undone(a, &drift[0], Side::Plates).1, undone(b, &drift[1], Side::Plates).1];
    let (_, alpha) = triangulate::solve([&a.on, &b.on], [&plates[0], &plates[1]]);
    let (mut as_is, mut corrected, mut count) = (0.0_f64, 0.0_f64, 0_usize);
    for (k, _) in alpha.iter().enumerate().filter(|&(_, &alpha)| alpha > 0.9) {
        for c in 0..3 {
            let (on_a, on_b) = (f64::from(a.on.pixels[k][c]), f64::from(b.on.pixels[k][c]));
            let (gain_a, gain_b) = (f64::from(drift[0].gain[c]), f64::from(drift[1].gain[c]));
            // Square roots: what reflects the backdrop differs for its own reasons, and must not decide alone.
            as_is += libm::sqrt((on_a - on_b).abs());
            corrected += libm::sqrt((on_a / gain_a - on_b / gain_b).abs());
        }
        count += 1;
    }
    if count >= 50 && corrected < as_is { Side::Photos } else { Side::Plates }
}

/// Photo and plate with the drift undone on one side.
pub(super) fn undone(backed: &Backed, drift: &Drift, side: Side) -> (Image, Image) {
    let scaled = |image: &Image, factor: [f32; 3]| {
        let pixels = image.pixels.iter().map(|pixel| std::array::from_fn(|c| pixel[c] * factor[c])).collect();
        Image { width: image.width, height: image.height, pixels }
    };
    match side {
        Side::Plates => (backed.on.clone(), scaled(&backed.plate, drift.gain)),
        Side::Photos => (scaled(&backed.on, drift.gain.map(|gain| 1.0 / gain.max(0.1))), backed.plate.clone()),
    }
}
