//! A stack merged to radiance.

use super::response::Response;
use super::solve::hat;
use super::stack::Stack;
use gonio_scene::image::Image;
use rayon::prelude::*;

/// Largest value that is not saturated, and smallest above the noise floor: codes 250 and 4 of 255.
const SATURATED: f32 = 250.5 / 255.0;
const FLOOR: f32 = 3.5 / 255.0;
/// Disagreement in ln(radiance), beside five standard deviations of a code, beyond which something moved.
const MOVED: f64 = 0.35;
/// And in value: ten codes.
const MOVED_VALUE: f32 = 10.0 / 255.0;
/// A pixel's noise in codes, at least: rounding and what is usual for 8-bit files.
const NOISE_CODES: f64 = 1.0;

/// What is known of a pixel; the worst of its channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mark {
    /// Exposed in at least one shot.
    Good,
    /// A shot was left out because something moved there.
    Moved,
    /// Below the noise floor in every shot: the radiance is an upper bound.
    Dark,
    /// Saturated in every shot: the radiance is a lower bound.
    Saturated,
    /// In no shot's frame: the radiance is 0.
    Outside,
}

/// A radiance map with marks.
#[derive(Debug, Clone)]
pub struct Merged {
    /// Radiance up to a scale per stack: exposure at code 128 is 1, over seconds.
    pub radiance: Image,
    /// One a pixel.
    pub marks: Vec<Mark>,
    /// Names of shots that are saturated throughout, or dark throughout: they add nothing.
    pub useless: Vec<(String, Mark)>,
}

/// Merges a stack: E = sum w E_j / sum w over the exposed shots. A weight is the inverse variance of E_j times Debevec and
/// Malik's hat, both at the value that a first, median estimate predicts: weights from the measured value would pull the
/// mean. A shot that contradicts the median beyond its noise is left out of the pixel: something moved.
pub fn merge(stack: &Stack, response: &Response) -> Merged {
    let (width, height) = stack.size();
    let times = stack.log_times();
    let results: Vec<([f32; 3], Mark)> =
        (0..width * height).into_par_iter().map(|pixel| merge_pixel(stack, response, &times, pixel)).collect();
    let (pixels, marks) = results.into_iter().unzip();
    Merged { radiance: Image { width: width as u32, height: height as u32, pixels }, marks, useless: useless(stack) }
}

fn useless(stack: &Stack) -> Vec<(String, Mark)> {
    let share = |shot: usize, wanted: &dyn Fn(f32) -> bool| {
        let (width, height) = stack.size();
        let values = (0..width * height).filter_map(|pixel| stack.value(shot, pixel));
        let (hits, all) = values.fold((0_usize, 1_usize), |(hits, all), value| {
            (hits + usize::from(value.iter().all(|&value| wanted(value))), all + 1)
        });
        hits as f64 / all as f64
    };
    let mut useless = Vec::new();
    for (k, shot) in stack.shots().iter().enumerate() {
        if share(k, &|value| value > SATURATED) > 0.98 {
            useless.push((shot.name.clone(), Mark::Saturated));
        } else if share(k, &|value| value < FLOOR) > 0.98 {
            useless.push((shot.name.clone(), Mark::Dark));
        }
    }
    useless
}

fn merge_pixel(stack: &Stack, response: &Response, times: &[f64], pixel: usize) -> ([f32; 3], Mark) {
    let values: Vec<Option<[f32; 3]>> = (0..times.len()).map(|shot| stack.value(shot, pixel)).collect();
    if values.iter().all(Option::is_none) {
        return ([0.0; 3], Mark::Outside);
    }
    let reference: [Option<f64>; 3] = std::array::from_fn(|c| median(response, times, &values, c));
    let moved: Vec<bool> = (0..times.len())
        .map(|shot| {
            (0..3).any(|c| values[shot].is_some_and(|v| contradicts(response, times[shot], v[c], reference[c], c)))
        })
        .collect();
    let mut mark = if moved.contains(&true) { Mark::Moved } else { Mark::Good };
    let mut radiance = [0.0_f32; 3];
    for c in 0..3 {
        let (value, found) = match reference[c] {
            Some(reference) => (mean(response, times, &values, &moved, c, reference), Mark::Good),
            None => bound(response, times, &values, c),
        };
        radiance[c] = value as f32;
        mark = mark.max(found);
    }
    (radiance, mark)
}

fn exposed(value: f32) -> bool {
    (FLOOR..=SATURATED).contains(&value)
}

/// Standard deviation of ln(radiance) from one value.
fn deviation(response: &Response, channel: usize, value: f32) -> f64 {
    response.slope(channel, value) * NOISE_CODES
}

/// Weighted median of ln(radiance) over the exposed shots.
fn median(response: &Response, times: &[f64], values: &[Option<[f32; 3]>], c: usize) -> Option<f64> {
    let mut found: Vec<(f64, f64)> = values
        .iter()
        .zip(times)
        .filter_map(|(value, time)| {
            let value = value.as_ref()?[c];
            let weight = (hat(value) + 1e-3) / deviation(response, c, value).max(0.01);
            exposed(value).then(|| (response.log_exposure(c, value) - time, weight))
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * found.iter().map(|entry| entry.1).sum::<f64>();
    let mut sum = 0.0;
    for &(value, weight) in &found {
        sum += weight;
        if sum >= half {
            return Some(value);
        }
    }
    None
}

/// Whether a shot's value cannot come from the radiance that the median says.
fn contradicts(response: &Response, time: f64, value: f32, reference: Option<f64>, c: usize) -> bool {
    let Some(reference) = reference.filter(|_| exposed(value)) else { return false };
    let predicted = response.value(c, reference + time).clamp(FLOOR, SATURATED);
    let noise = deviation(response, c, value).max(deviation(response, c, predicted));
    // Where the curve is steep, such as in a film's fog, a few codes are a large ratio, and nothing moved.
    (value - predicted).abs() > MOVED_VALUE
        && (response.log_exposure(c, value) - time - reference).abs() > MOVED + 5.0 * noise
}

fn mean(
    response: &Response,
    times: &[f64],
    values: &[Option<[f32; 3]>],
    moved: &[bool],
    c: usize,
    reference: f64,
) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for (shot, value) in values.iter().enumerate() {
        let Some(value) = value.map(|value| value[c]).filter(|&value| exposed(value) && !moved[shot]) else { continue };
        let predicted = response.value(c, reference + times[shot]);
        let deviation = deviation(response, c, predicted);
        let weight = (hat(predicted) + 1e-4) / (deviation * deviation);
        sum += weight * libm::exp(response.log_exposure(c, value) - times[shot]);
        total += weight;
    }
    if total > 0.0 { sum / total } else { libm::exp(reference) }
}

/// What the shots say of a radiance that none of them holds.
fn bound(response: &Response, times: &[f64], values: &[Option<[f32; 3]>], c: usize) -> (f64, Mark) {
    // The longest shot comes first: dark there is dark everywhere, saturated in the shortest everywhere.
    let present = || values.iter().enumerate().filter_map(|(shot, value)| value.map(|value| (shot, value[c])));
    if let Some((shot, _)) = present().rev().find(|&(_, value)| value > SATURATED) {
        return (libm::exp(response.log_exposure(c, SATURATED) - times[shot]), Mark::Saturated);
    }
    let (shot, value) = present().next().unwrap_or((0, 0.0));
    (libm::exp(response.log_exposure(c, value.max(0.5 / 255.0)) - times[shot]), Mark::Dark)
}
