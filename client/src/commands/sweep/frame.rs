//! From a frame's films to its files.

use crate::failure::Failure;
use gonio_scene::capture::{Response, Sensor, srgb};
use gonio_scene::film::FIRST_HIT_CHANNELS;
use gonio_scene::image::{encode_exr_channels, encode_png8};
use gonio_scene::{Capture, Film, SensorStage};
use gonio_sweep::{FrameDigest, Output, Plan, Record};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

/// A frame, ready to be written.
pub(super) struct Written {
    /// A file for each of the plan's outputs.
    pub files: Vec<(Output, Vec<u8>)>,
    /// What is kept beside them.
    pub record: Record,
    /// Photo values.
    pub image: Film,
}

/// Encodes a frame: `film` holds exposed light, and `hits` first hits where they are wanted. `capture` is the plan's
/// capture at the frame's numbers.
///
/// # Errors
/// None that a film of the farm could cause.
pub(super) fn encode(
    plan: &Plan,
    capture: &Capture,
    digest: FrameDigest,
    film: &Film,
    hits: Option<&Film>,
    measured: (u64, f64),
) -> Result<Written, Failure> {
    let photo = SensorStage::of(capture, film.photo).photo_values(film);
    let response = &capture.sensor.response;
    let name = digest.to_string();
    let mut files = Vec::with_capacity(plan.outputs.len());
    for &output in &plan.outputs {
        let bytes = match output {
            Output::Exr => exr(&name, &photo, &["R", "G", "B"])?,
            Output::Png => encode_png8(&name, photo.width, photo.height, &pixels(&photo, response, plan.png_stops))?,
            Output::Rgb => {
                let noisy = noisy(&photo, &capture.sensor, digest);
                encode_png8(&name, photo.width, photo.height, &pixels(&noisy, response, 0.0))?
            }
            Output::Buffers => match hits {
                Some(hits) => exr(&name, hits, &FIRST_HIT_CHANNELS)?,
                None => return Err(Failure::Failed("the farm sent no first hits".to_owned())),
            },
        };
        files.push((output, bytes));
    }
    let (invalid, seconds) = measured;
    let record = Record::of(name, &photo, response, invalid, seconds);
    Ok(Written { files, record, image: photo })
}

/// Photo values as the sensor would have measured them, by random numbers that follow from the frame's digest.
fn noisy(film: &Film, sensor: &Sensor, digest: FrameDigest) -> Film {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(digest.seed());
    let mut noisy = film.clone();
    for value in noisy.channels.iter_mut().flatten() {
        // Box and Muller's method, of which one of the two numbers is used.
        let [radius, turn] = [0, 1].map(|_| ((random.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64);
        let normal = (-2.0 * libm::log(radius)).sqrt() * libm::cos(std::f64::consts::TAU * turn);
        *value += (sensor.variance(f64::from(*value)).sqrt() * normal) as f32;
    }
    noisy
}

fn exr(name: &str, film: &Film, channels: &[&str]) -> Result<Vec<u8>, Failure> {
    let named: Vec<(&str, Vec<f32>)> = channels.iter().copied().zip(film.channels.iter().cloned()).collect();
    Ok(encode_exr_channels(name, film.width, film.height, &named)?)
}

/// Photo values on a screen; those of a linear sensor through the sRGB curve, others as they are.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn pixels(film: &Film, response: &Response, stops: f64) -> Vec<[u8; 3]> {
    let factor = libm::exp2(stops);
    let byte = |value: f32| {
        let bright = (factor * f64::from(value)).clamp(0.0, 1.0);
        let encoded = if response.is_linear() { srgb(bright).0 } else { bright };
        (255.0 * encoded).round().clamp(0.0, 255.0) as u8
    };
    let count = film.width as usize * film.height as usize;
    let at = |channel: usize, i: usize| film.channels.get(channel).and_then(|c| c.get(i)).copied().unwrap_or(0.0);
    (0..count).map(|i| [0, 1, 2].map(|channel| byte(at(channel, i)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pngs_follow_the_srgb_curve_and_the_stops() {
        let film = Film { width: 3, height: 1, channels: vec![vec![0.0, 0.125, 9.0]; 3], ..Film::default() };
        // sRGB of 0.125 is 0.3885, of 0.5 it is 0.7354.
        assert_eq!(pixels(&film, &Response::Linear, 0.0), [[0; 3], [99; 3], [255; 3]]);
        assert_eq!(pixels(&film, &Response::Linear, 2.0), [[0; 3], [188; 3], [255; 3]]);
        assert_eq!(pixels(&film, &Response::Srgb, 2.0), [[0; 3], [128; 3], [255; 3]]);
    }
}
