//! The photographs' own noise: what of a residual none of its neighbours shares.
//!
//! With z the residual in the sensor's standard deviations, d = z(i) - (z(i-1) + z(i+1)) / 2 along rows or columns has 1.5 times
//! the variance of white noise, and nothing of a misfit that is linear over three pixels. Edges that are misplaced are outliers: the median absolute
//! deviation passes them over (Donoho and Johnstone 1994 estimate noise so). The render's own noise is known from two independent renders A and B:
//! the deviation of (d_A - d_B) / 2 is what it adds to that of (d_A + d_B) / 2. The smaller of rows and columns counts: stripes of a texture are no noise.

use crate::evidence::ChannelNoise;
use gonio_scene::{Capture, Film, Photograph, sensor_stage::SensorStage};

/// Standard deviation over median absolute deviation, of a normal distribution.
const NORMAL: f64 = 1.4826;
/// Efficiency of the median absolute deviation beside the standard deviation, of a normal distribution (Huber 1981).
const EFFICIENCY: f64 = 0.37;
/// Variance of d over that of z.
const WEIGHTS: f64 = 1.5;
/// Fewest differences that say anything.
const FEWEST: usize = 100;

/// Differences along rows and along columns, by channel: of the mean of two renders, and of half their difference.
#[derive(Debug, Default)]
pub struct Differences {
    mean: [[Vec<f64>; 3]; 2],
    half: [[Vec<f64>; 3]; 2],
}

impl Differences {
    /// Adds a photo's, from two independent renders of it.
    pub fn add(&mut self, capture: &Capture, films: [&Film; 2], photograph: &Photograph) {
        let (width, height) = (films[0].width as usize, films[0].height as usize);
        let stage = SensorStage::of(capture, films[0].photo);
        let counts = |i: usize| photograph.counts.get(i).copied().unwrap_or(false);
        let residual = |film: &Film, i: usize| -> [f64; 3] {
            let exposed = [0, 1, 2].map(|c| f64::from(film.channels[c][i]));
            let value = stage.value(exposed, i % width, i / width).value;
            [0, 1, 2].map(|c| {
                let variance = capture.sensor.variance(f64::from(photograph.surroundings[i][c]));
                (f64::from(photograph.image.pixels[i][c]) - value[c]) / variance.sqrt()
            })
        };
        // Triples that share no pixel are independent.
        for (along, step) in [1, width].into_iter().enumerate() {
            let lines = if along == 0 { (height, width, width) } else { (width, height, 1) };
            for start in (0..lines.0).map(|line| line * lines.2) {
                for middle in (1..lines.1.saturating_sub(1)).step_by(3).map(|k| start + k * step) {
                    let three = [middle - step, middle, middle + step];
                    if !three.iter().all(|i| counts(*i)) {
                        continue;
                    }
                    let d = films.map(|film| {
                        let [before, here, after] = three.map(|i| residual(film, i));
                        [0, 1, 2].map(|c| here[c] - 0.5 * (before[c] + after[c]))
                    });
                    let [a, b] = d;
                    for (c, (a, b)) in a.iter().zip(b).enumerate() {
                        self.mean[along][c].push(0.5 * (a + b));
                        self.half[along][c].push(0.5 * (a - b));
                    }
                }
            }
        }
    }

    /// Red, green and blue noise; none where too little was seen.
    #[must_use]
    pub fn noise(mut self) -> Option<[ChannelNoise; 3]> {
        let [rows, columns] = [0, 1].map(|along| {
            [0, 1, 2].map(|c| {
                let (mean, half) = (&mut self.mean[along][c], &mut self.half[along][c]);
                let n = mean.len();
                let [all, render] = [mean, half].map(|values| variance(values) / WEIGHTS);
                let relative = (2.0 / (EFFICIENCY * n.max(1) as f64)).sqrt();
                (n >= FEWEST).then(|| ChannelNoise { variance: all - render, error: relative * all.hypot(render) })
            })
        });
        let smaller = |c: usize| match (rows[c], columns[c]) {
            (Some(a), Some(b)) => Some(if a.variance < b.variance { a } else { b }),
            _ => None,
        };
        Some([smaller(0)?, smaller(1)?, smaller(2)?])
    }
}

/// Variance by the median absolute deviation from zero.
fn variance(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    values.iter_mut().for_each(|v| *v = v.abs());
    let middle = values.len() / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    (NORMAL * *median).powi(2)
}
