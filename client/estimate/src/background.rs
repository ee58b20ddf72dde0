//! The colours of an image, as what a pixel has that is not the part's.

use crate::picture::Picture;

/// Bins along each channel.
const BINS: usize = 32;

/// Part of the probability that is spread over all colours: one that never occurs is not impossible.
const ANY: f32 = 0.02;

/// A density of colours over the unit cube.
pub(crate) struct Background {
    logarithms: Vec<f32>,
}

impl Background {
    /// Of all the pixels, the part's own among them: it takes a small share of an image.
    pub fn of(picture: &Picture) -> Self {
        let cells = BINS * BINS * BINS;
        let mut counts = vec![0f32; cells];
        let pixels = picture.pixels.as_raw().chunks_exact(3);
        #[allow(clippy::cast_precision_loss)]
        let all = pixels.len().max(1) as f32;
        for pixel in pixels {
            counts[cell([pixel[0], pixel[1], pixel[2]])] += 1.0;
        }
        // A colour's neighbours are as likely as noise and filters make them: (1, 2, 1) / 4 along each channel.
        for stride in [1, BINS, BINS * BINS] {
            let old = counts.clone();
            for (index, count) in counts.iter_mut().enumerate() {
                let place = index / stride % BINS;
                let below = if place > 0 { old[index - stride] } else { 0.0 };
                let above = if place + 1 < BINS { old[index + stride] } else { 0.0 };
                *count = (below + 2.0 * old[index] + above) / 4.0;
            }
        }
        #[allow(clippy::cast_precision_loss)]
        let cells = cells as f32;
        let density = |count: f32| libm::logf((1.0 - ANY) * count / all * cells + ANY);
        Self { logarithms: counts.into_iter().map(density).collect() }
    }

    /// The logarithm of a colour's density.
    pub fn logarithm(&self, colour: [f32; 3]) -> f32 {
        self.logarithms[cell(colour)]
    }
}

fn cell(colour: [f32; 3]) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // 0 to BINS
    let bin = |value: f32| ((value.clamp(0.0, 1.0) * BINS as f32) as usize).min(BINS - 1);
    (bin(colour[0]) * BINS + bin(colour[1])) * BINS + bin(colour[2])
}
