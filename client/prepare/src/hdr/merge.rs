//! A stack merged to radiance.

use super::ghost;
use super::response::Response;
use super::solve::hat;
use super::stack::Stack;
use gonio_scene::image::Image;
use rayon::prelude::*;

/// Largest value that is not saturated, and smallest above the noise floor: codes 250 and 4 of 255.
pub(super) const SATURATED: f32 = 250.5 / 255.0;
pub(super) const FLOOR: f32 = 3.5 / 255.0;
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
/// mean. A shot in which something moved at a pixel is left out there.
pub fn merge(stack: &Stack, response: &Response) -> Merged {
    let (width, height) = stack.size();
    let times = stack.log_times();
    let reference: Vec<[f32; 3]> = (0..width * height)
        .into_par_iter()
        .map(|pixel| {
            let values = values(stack, pixel);
            std::array::from_fn(|c| median(response, &times, &values, c).map_or(f32::NAN, |median| median as f32))
        })
        .collect();
    let moved: Vec<Vec<bool>> = (0..times.len()).map(|shot| ghost::moved(stack, response, shot, &reference)).collect();
    let results: Vec<([f32; 3], Mark)> = (0..width * height)
        .into_par_iter()
        .map(|pixel| {
            let left_out: Vec<bool> = moved.iter().map(|shot| shot[pixel]).collect();
            merge_pixel(response, &times, &values(stack, pixel), reference[pixel], &left_out)
        })
        .collect();
    let (pixels, marks) = results.into_iter().unzip();
    Merged { radiance: Image { width: width as u32, height: height as u32, pixels }, marks, useless: useless(stack) }
}

/// A pixel's value in every shot.
fn values(stack: &Stack, pixel: usize) -> Vec<Option<[f32; 3]>> {
    (0..stack.shots().len()).map(|shot| stack.value(shot, pixel)).collect()
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

fn merge_pixel(
    response: &Response,
    times: &[f64],
    values: &[Option<[f32; 3]>],
    reference: [f32; 3],
    moved: &[bool],
) -> ([f32; 3], Mark) {
    if values.iter().all(Option::is_none) {
        return ([0.0; 3], Mark::Outside);
    }
    let mut mark = if moved.contains(&true) { Mark::Moved } else { Mark::Good };
    let mut radiance = [0.0_f32; 3];
    for c in 0..3 {
        let (value, found) = if reference[c].is_nan() {
            bound(response, times, values, c)
        } else {
            (mean(response, times, values, moved, c, f64::from(reference[c])), Mark::Good)
        };
        radiance[c] = value as f32;
        mark = mark.max(found);
    }
    (radiance, mark)
}

/// Whether a value is neither saturated nor below the noise floor.
pub(super) fn exposed(value: f32) -> bool {
    (FLOOR..=SATURATED).contains(&value)
}

/// Standard deviation of ln(radiance) from one value.
pub(super) fn deviation(response: &Response, channel: usize, value: f32) -> f64 {
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
