//! Exposure and colour balance that changed between a photo and its backdrop.

use super::Backed;
use super::triangulate;
use gonio_scene::SceneError;
use gonio_scene::image::Image;

/// Largest drift in ln(gain): a factor of two.
const LARGEST: f64 = 0.7;
/// Bins of the histogram of ln(gain).
const BINS: usize = 57;
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

/// The gain that most pixels share, refined over those that share it.
pub(super) fn estimate(backed: &Backed) -> Result<Drift, SceneError> {
    let pairs = || backed.on.pixels.iter().zip(&backed.plate.pixels);
    let mut gain = [1.0_f32; 3];
    for (c, gain) in gain.iter_mut().enumerate() {
        let mut bins = [0.0_f64; BINS];
        for (on, plate) in pairs().filter(|(on, plate)| plate[c] > 0.04 && on[c] > 0.02 && on[c] < 0.99) {
            let log = libm::log(f64::from(on[c] / plate[c]));
            let place = (log / LARGEST + 1.0) * 0.5 * (BINS - 1) as f64;
            if place >= 0.0 && place < (BINS - 1) as f64 {
                let (bin, part) = (place as usize, place.fract());
                // Dark pixels have coarse ratios.
                let weight = f64::from(plate[c]);
                bins[bin] += weight * (1.0 - part);
                bins[bin + 1] += weight * part;
            }
        }
        let smooth = |k: usize| bins[k - 1] + 2.0 * bins[k] + bins[k + 1];
        let peak = (1..BINS - 1).max_by(|&a, &b| smooth(a).total_cmp(&smooth(b))).filter(|&k| smooth(k) > 0.0);
        // A channel that the backdrop lacks keeps its gain: nothing there depends on it.
        let Some(peak) = peak else { continue };
        let mut found = libm::exp((2.0 * peak as f64 / (BINS - 1) as f64 - 1.0) * LARGEST);
        // Ever narrower: shadows lie below the gain in close succession, and would pull it down.
        for width in [0.02, 0.015, 0.012, 0.01, 0.008, 0.006, 0.006, 0.006] {
            let (mut sum, mut total) = (0.0, 1e-12);
            for (on, plate) in pairs().filter(|(on, _)| on[c] < 0.99) {
                let (on, plate) = (f64::from(on[c]), f64::from(plate[c]));
                let off = (on - found * plate) / width;
                let weight = 1.0 / ((1.0 + off * off) * (1.0 + off * off));
                sum += weight * on * plate;
                total += weight * plate * plate;
            }
            found = sum / total;
        }
        *gain = found as f32;
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
