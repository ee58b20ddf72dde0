//! What moved between the shots of a stack: ghosts, which a shot would leave in the map.

use super::merge::{FLOOR, SATURATED, deviation, exposed};
use super::response::Response;
use super::stack::Stack;
use rayon::prelude::*;

/// Least disagreement of something that moved: in ln(radiance), beside five standard deviations of a code.
const LEAST: f64 = 0.35;
/// And in value: ten codes.
const LEAST_VALUE: f32 = 10.0 / 255.0;
/// Standard deviations of what a shot's values of one brightness are off by, that nothing moved.
const DEVIATIONS: f32 = 6.0;
/// Codes of one brightness.
const BIN_CODES: usize = 16;
const BINS: usize = 256 / BIN_CODES;
/// Largest error of a response, and largest deviation: beyond, most of a brightness has moved.
const LARGEST_OFFSET: f32 = 20.0 / 255.0;
const LARGEST_SCALE: f32 = 6.0 / 255.0;
/// Fewest pixels that tell how far off a brightness is.
const FEWEST: usize = 64;
/// Of the 3 x 3 pixels about one that moved, how many contradict, at least: noise is not coherent.
const COHERENT: usize = 5;

/// How far a shot's values of one predicted brightness are from the prediction.
#[derive(Clone, Copy)]
struct Error {
    offset: f32,
    scale: f32,
}

/// For every pixel whether something moved there in `shot`. `reference` is ln(radiance) by the median of all shots, NaN
/// where none is exposed. A value contradicts it where it lies further off than all of these explain:
/// - noise: so many standard deviations of the shot's own values of that brightness;
/// - the response's error: those values' median offset, such as a film's fog, which short exposures have more of;
/// - alignment: what the 3 x 3 pixels about it are predicted to have, the shot being off by up to a pixel.
///
/// Values that contradict count where most of their neighbours do, too.
pub(super) fn moved(stack: &Stack, response: &Response, shot: usize, reference: &[[f32; 3]]) -> Vec<bool> {
    let (width, height) = stack.size();
    let time = stack.log_times()[shot];
    let predicted: Vec<[f32; 3]> = reference
        .par_iter()
        .map(|log| std::array::from_fn(|c| predict(response, c, f64::from(log[c]) + time)))
        .collect();
    let errors: [[Error; BINS]; 3] = std::array::from_fn(|c| errors(stack, shot, &predicted, c));
    let contradicts = |pixel: usize| {
        let Some(value) = stack.value(shot, pixel) else { return false };
        (0..3).any(|c| {
            // What is clipped contradicts, too, where it should not be: it adds nothing itself, but its neighbours may.
            let (value, own) = (value[c].clamp(FLOOR, SATURATED), predicted[pixel][c]);
            if own.is_nan() {
                return false;
            }
            let error = errors[c][bin(own)];
            let allowed = LEAST_VALUE.max(DEVIATIONS * error.scale);
            let (least, most) = reach(&predicted, [width, height], pixel, c);
            let known = value - error.offset;
            if known >= least - allowed && known <= most + allowed {
                return false;
            }
            // Where the curve is steep, a few codes are a large ratio, and where it is flat a small one.
            let noise = deviation(response, c, value).max(deviation(response, c, own));
            let off = response.log_exposure(c, value) - time - f64::from(reference[pixel][c]);
            off.abs() > LEAST + 5.0 * noise
        })
    };
    let raw: Vec<bool> = (0..width * height).into_par_iter().map(contradicts).collect();
    let around = |set: &[bool], pixel: usize| neighbours([width, height], pixel).filter(|&k| set[k]).count();
    let core: Vec<bool> =
        (0..raw.len()).into_par_iter().map(|pixel| raw[pixel] && around(&raw, pixel) >= COHERENT).collect();
    // A ghost's corners have few neighbours of their kind.
    (0..raw.len()).into_par_iter().map(|pixel| raw[pixel] && around(&core, pixel) > 0).collect()
}

/// The value that a shot should have; NaN where nothing is known.
fn predict(response: &Response, c: usize, log_exposure: f64) -> f32 {
    if log_exposure.is_nan() { f32::NAN } else { response.value(c, log_exposure).clamp(FLOOR, SATURATED) }
}

fn bin(value: f32) -> usize {
    ((value * 255.0) as usize / BIN_CODES).min(BINS - 1)
}

/// Median offset and robust standard deviation (1.4826 times the median absolute deviation) by predicted brightness.
fn errors(stack: &Stack, shot: usize, predicted: &[[f32; 3]], c: usize) -> [Error; BINS] {
    let mut found: [Vec<f32>; BINS] = Default::default();
    for (pixel, own) in predicted.iter().enumerate() {
        let Some(value) = stack.value(shot, pixel).map(|value| value[c]) else { continue };
        if exposed(value) && !own[c].is_nan() {
            found[bin(own[c])].push(value - own[c]);
        }
    }
    found.map(|mut offsets| {
        let code = 1.0 / 255.0;
        if offsets.len() < FEWEST {
            return Error { offset: 0.0, scale: code };
        }
        let offset = middle(&mut offsets);
        offsets.iter_mut().for_each(|value| *value = (*value - offset).abs());
        let scale = (1.4826 * middle(&mut offsets)).clamp(code, LARGEST_SCALE);
        Error { offset: offset.clamp(-LARGEST_OFFSET, LARGEST_OFFSET), scale }
    })
}

fn middle(values: &mut [f32]) -> f32 {
    let place = values.len() / 2;
    *values.select_nth_unstable_by(place, f32::total_cmp).1
}

/// Least and largest predicted value about a pixel.
fn reach(predicted: &[[f32; 3]], size: [usize; 2], pixel: usize, c: usize) -> (f32, f32) {
    let own = predicted[pixel][c];
    // `min` and `max` pass over NaN.
    neighbours(size, pixel).fold((own, own), |(least, most), k| (least.min(predicted[k][c]), most.max(predicted[k][c])))
}

/// The pixels of the 3 x 3 square about one, itself included.
fn neighbours([width, height]: [usize; 2], pixel: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (pixel % width, pixel / width);
    let columns = x.saturating_sub(1)..(x + 2).min(width);
    (y.saturating_sub(1)..(y + 2).min(height))
        .flat_map(move |row| columns.clone().map(move |column| row * width + column))
}
