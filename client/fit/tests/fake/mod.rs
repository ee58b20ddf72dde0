//! A renderer for tests: an analytic rough-plastic ball on a Lambertian board, lit by a lamp beside the camera, with the
//! noise of a Monte Carlo renderer and of a sensor put on top.
//!
//! The model is smooth and known in closed form, its noise has known size and two independent halves; so the truth, its
//! errors and the bias of a method that is not debiased are all known too.

#![allow(dead_code, clippy::cast_precision_loss)]

pub mod scene;
pub mod shading;

use gonio_fit::{Evaluate, EvaluateError, Watch};
use gonio_scene::capture::Sensor;
use gonio_scene::{Capture, Evaluation, EvaluationRequest, PhotoStatistics, Progress};
pub use scene::Scene;
use shading::Pixel;

/// Renders and compares, and remembers what it was asked.
pub struct Fake {
    pub capture: Capture,
    pixels: Vec<Vec<Pixel>>,
    photos: Vec<Vec<[f64; 3]>>,
    /// Relative standard deviation of one sample.
    pub render_noise: f64,
    /// Whether the sums come from the mean of the halves, as in plain least squares, instead of one from each.
    pub plain: bool,
    /// Refuses, as a user who stops, after this many evaluations.
    pub cancel_after: Option<usize>,
    pub requests: Vec<EvaluationRequest>,
}

impl Fake {
    pub fn new(scene: &Scene) -> Self {
        let capture = scene.capture();
        let mut truth = capture.clone();
        truth.set_numbers(&scene.truth).unwrap();
        let pixels: Vec<Vec<Pixel>> = (0..capture.photos.len()).map(|p| scene.pixels(p)).collect();
        let photos = pixels
            .iter()
            .enumerate()
            .map(|(p, list)| {
                let expose = |(i, pixel): (usize, &Pixel)| {
                    let clean = pixel.value(&truth, p);
                    std::array::from_fn(|c| {
                        let noise = gauss(&[scene.data_seed, 77, p as u64, i as u64, c as u64]);
                        clean[c] + truth.sensor.variance(clean[c]).sqrt() * noise
                    })
                };
                list.iter().enumerate().map(expose).collect()
            })
            .collect();
        let render_noise = scene.render_noise;
        Self { capture, pixels, photos, render_noise, plain: false, cancel_after: None, requests: Vec::new() }
    }

    /// Adds structure that the model does not have: `amount` times a pattern, per photo.
    pub fn disturb(&mut self, amount: f64) {
        for (p, photo) in self.photos.iter_mut().enumerate() {
            let factor = 1.0 + amount * gauss(&[5, p as u64]);
            photo.iter_mut().flatten().for_each(|v| *v *= factor);
        }
    }

    /// Sets a photo's values.
    pub fn paint(&mut self, value: f64) {
        self.photos.iter_mut().flatten().flatten().for_each(|v| *v = value);
    }

    /// Leaves no pixel.
    pub fn mask_everything(&mut self) {
        self.pixels.iter_mut().for_each(Vec::clear);
    }

    fn compare(&self, request: &EvaluationRequest, model: &Capture, photo: usize) -> PhotoStatistics {
        let side = request.columns.len() + 1;
        let mut sums = PhotoStatistics {
            photo,
            gram: vec![0.0; side * side],
            noise: vec![0.0; side * side],
            ..PhotoStatistics::default()
        };
        let moved: Vec<(Capture, Capture, f64)> = request
            .columns
            .iter()
            .map(|column| {
                let h = 1e-5 * column.value.abs().max(1e-2);
                let at = |value: f64| {
                    let mut copy = model.clone();
                    copy.set_numbers(&column.numbers(value).collect::<Vec<_>>()).unwrap();
                    copy
                };
                let (low, high) = ((column.value - h).max(column.range.min), (column.value + h).min(column.range.max));
                (at(low), at(high), high - low)
            })
            .collect();
        let spread = self.render_noise / (f64::from(request.samples) / 2.0).sqrt();
        let factor = |i: usize, half: u64| {
            1.0 + spread * gauss(&[request.seed, 99, u64::from(request.samples), photo as u64, i as u64, half])
        };
        let pixels = self.pixels[photo].len();
        let factors: Vec<[f64; 2]> = (0..pixels).map(|i| [factor(i, 0), factor(i, 1)]).collect();
        for (i, pixel) in self.pixels[photo].iter().enumerate() {
            let mut pixel_moves = vec![0.0; side];
            // As the coordinator does it: how large a pixel's noise is, from its neighbours.
            let (from, to) = (i.saturating_sub(12), (i + 13).min(pixels));
            let around = |c: usize| {
                let sum: f64 = self.photos[photo][from..to].iter().map(|p| p[c]).sum();
                (sum - self.photos[photo][i][c]) / (to - from - 1) as f64
            };
            let clean = pixel.value(model, photo);
            let slopes: Vec<[f64; 3]> = moved
                .iter()
                .map(|(low, high, distance)| {
                    let (a, b) = (pixel.value(low, photo), pixel.value(high, photo));
                    std::array::from_fn(|c| (b[c] - a[c]) / distance)
                })
                .collect();
            // Value and derivatives come from the same samples: their noise is the same.
            for c in 0..3 {
                let y = self.photos[photo][i][c];
                let halves = factors[i].map(|f| {
                    let mut row = vec![f * clean[c] - y];
                    row.extend(slopes.iter().map(|s| f * s[c]));
                    row
                });
                self.add(&mut sums, &halves, y, model.sensor.variance(around(c)), &model.sensor, &mut pixel_moves);
            }
            for (i, a) in pixel_moves.iter().enumerate() {
                for (j, b) in pixel_moves.iter().enumerate() {
                    sums.noise[i * side + j] += a * b;
                }
            }
        }
        sums
    }

    fn add(
        &self,
        sums: &mut PhotoStatistics,
        halves: &[Vec<f64>; 2],
        y: f64,
        variance: f64,
        sensor: &Sensor,
        moves: &mut [f64],
    ) {
        let [a, b] = halves;
        let mean: Vec<f64> = a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
        let half: Vec<f64> = a.iter().zip(b).map(|(a, b)| 0.5 * (a - b)).collect();
        for i in 0..a.len() {
            for j in 0..a.len() {
                let product = if self.plain { mean[i] * mean[j] } else { 0.5 * (a[i] * b[j] + b[i] * a[j]) };
                sums.gram[i * a.len() + j] += product / variance;
            }
            moves[i] += (mean[i] * half[0] + half[i] * mean[0]) / variance;
        }
        sums.observations += 1;
        sums.noise_floor += sensor.variance(y) / variance;
        sums.render_noise += half[0] * half[0] / variance;
        sums.squared_error += a[0] * b[0];
        sums.log_variance += variance.ln_();
        sums.peak = sums.peak.max(y);
    }
}

impl Evaluate for Fake {
    fn evaluate(&mut self, request: &EvaluationRequest, watch: &mut Watch<'_>) -> Result<Evaluation, EvaluateError> {
        if self.cancel_after.is_some_and(|n| self.requests.len() >= n) {
            return Err(EvaluateError::Cancelled);
        }
        self.requests.push(request.clone());
        let mut model = self.capture.clone();
        model.set_numbers(&request.numbers).map_err(|e| EvaluateError::Refused(e.to_string()))?;
        let photos: Vec<PhotoStatistics> = request.photos.iter().map(|p| self.compare(request, &model, *p)).collect();
        let pixels: u64 = request.photos.iter().map(|p| self.pixels[*p].len() as u64).sum();
        let primary_samples = pixels * u64::from(request.samples);
        if watch(&Progress { tasks_done: 1, tasks: 1, primary_samples, ..Progress::default() }).is_break() {
            return Err(EvaluateError::Cancelled);
        }
        Ok(Evaluation { photos, primary_samples, ..Evaluation::default() })
    }
}

/// The natural logarithm by the crate that the workspace allows.
trait Logarithm {
    fn ln_(self) -> f64;
}

impl Logarithm for f64 {
    fn ln_(self) -> f64 {
        libm::log(self)
    }
}

/// A uniform number in (0, 1), a pure function of its keys (splitmix64).
pub fn uniform(keys: &[u64]) -> f64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for key in keys {
        state = state.wrapping_add(*key).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state ^= state >> 27;
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^= state >> 31;
    }
    ((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

/// A standard normal number, a pure function of its keys (Box and Muller 1958).
pub fn gauss(keys: &[u64]) -> f64 {
    let with = |last: u64| uniform(&keys.iter().copied().chain([last]).collect::<Vec<_>>());
    (-2.0 * with(1).ln_()).sqrt() * libm::cos(2.0 * std::f64::consts::PI * with(2))
}
