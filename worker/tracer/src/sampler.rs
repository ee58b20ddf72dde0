//! Random numbers: a pure function of (seed, photo, pixel, half, sample, dimension).
//!
//! The first groups of four dimensions (the pixel, and everything at a path's first surface) are Owen-scrambled Sobol points
//! (Burley 2020, "Practical Hash-based Owen Scrambling", by the `sobol_burley` crate), with one scramble per pixel and
//! half; beyond 2^16 samples, by another scramble. Deeper in a path, where stratification gains little and Sobol points
//! cost more than the shading, the numbers are counted through the hash pcg4d (Jarzynski & Olano 2020, "Hash Functions
//! for GPU Rendering").

mod block;

pub use block::{BLOCK, Block, Branches, Keys, Lanes};

use sobol_burley::sample_4d;

/// Samples per scramble that the Sobol tables hold.
const SEQUENCE: u32 = 1 << 16;
/// Groups of four dimensions that are Sobol points.
const SOBOL_GROUPS: u32 = 3;

/// Paths that go on from each camera ray's first surface. The light of most scenes is smooth there but for what comes from
/// other surfaces, while the camera ray and the lamps cost more than half of the time: two paths share them.
/// Without unit; a power of two, so that shares are exact. 1 and 2 have been compared (`examples/noise.rs`): 2 has the lesser product of
/// variance and CPU time on every scene.
pub const SPLIT: u32 = 2;

/// What tells counted numbers from other uses of their hash.
const COUNTED: u32 = 0x9e37_79b9;

/// The sequence of one pixel in one half buffer.
#[derive(Debug, Clone, Copy)]
pub struct PixelSampler {
    scramble: u32,
}

/// The numbers of one sample, four at a time.
#[derive(Debug, Clone, Copy)]
pub struct Sampler<'b> {
    scramble: u32,
    index: u32,
    group: u32,
    /// Numbers that are there already, and this sample's lane among them.
    block: Option<(&'b Block, usize)>,
}

/// What takes its numbers aside.
#[derive(Debug, Clone, Copy)]
pub enum Aside {
    /// Whether an object is there, and where glare comes from.
    Choice,
    /// The path that glare follows.
    Glare,
    /// Lights of intensity 0 whose derivative is wanted.
    Dark,
    /// Where light that leaves a translucent surface has entered it.
    Below,
}

impl PixelSampler {
    /// The sequence for a pixel of a photo; `half` 0 or 1 gives independent sequences.
    #[must_use]
    pub fn new(seed: u64, photo: usize, x: u32, y: u32, half: u32) -> Self {
        let place = (u64::from(x) << 32 | u64::from(y)) ^ (photo as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mixed = mix(mix(seed ^ 0x5851_f42d_4c95_7f2d) ^ mix(place) ^ (u64::from(half) << 17));
        Self { scramble: fold(mix(mixed)) }
    }

    /// The numbers of sample `index`.
    #[must_use]
    pub fn sample(&self, index: u32) -> Sampler<'static> {
        let pad = index / SEQUENCE;
        let scramble =
            if pad == 0 { self.scramble } else { fold(mix(u64::from(self.scramble) << 32 | u64::from(pad))) };
        Sampler { scramble, index: index % SEQUENCE, group: 0, block: None }
    }

    /// The numbers of path number `branch` of [`SPLIT`] that go on from the first surface of camera ray `index`, whose own
    /// numbers group 0 is. The paths of all camera rays together are one stratified sequence.
    #[must_use]
    pub fn branch(&self, index: u32, branch: u32) -> Sampler<'static> {
        self.sample(index.wrapping_mul(SPLIT).wrapping_add(branch))
    }

    /// As [`Sampler::aside`], for all samples.
    #[must_use]
    pub fn aside(&self, which: Aside) -> Self {
        Self { scramble: salted(self.scramble, which) }
    }
}

fn salted(scramble: u32, which: Aside) -> u32 {
    let salt = (which as u64 + 1).wrapping_mul(0x6a09_e667_f3bc_c909);
    fold(mix(u64::from(scramble) ^ salt))
}

impl<'b> Sampler<'b> {
    /// The same numbers, read from a block, filled for the same pixel, whose sample `lane` this is.
    #[must_use]
    pub fn from(self, block: &'b Block, lane: usize) -> Self {
        Self { block: Some((block, lane)), ..self }
    }

    /// Passes over four numbers.
    #[inline]
    pub fn skip(&mut self) {
        self.group += 1;
    }

    /// Another sequence for the same sample, for decisions that must not shift this one's numbers; `which` tells
    /// them apart.
    #[must_use]
    pub fn aside(&self, which: Aside) -> Self {
        Self { scramble: salted(self.scramble, which), index: self.index, group: 0, block: None }
    }

    /// The next four numbers, each in [0, 1).
    #[inline]
    pub fn next4(&mut self) -> [f32; 4] {
        let numbers = if let Some((block, lane)) = self.block
            && self.group < block.ready
        {
            block.group(self.group).map(|dimension| dimension[lane])
        } else if self.group < SOBOL_GROUPS {
            sample_4d(self.index, self.group, self.scramble)
        } else {
            pcg4d([self.index, self.group, self.scramble, COUNTED]).map(unit)
        };
        self.group += 1;
        numbers
    }
}

/// Four well-mixed words from four counters.
#[inline(always)]
fn pcg4d([x, y, z, w]: [u32; 4]) -> [u32; 4] {
    let [x, y, z, w] = mixed([counted(x), counted(y), counted(z), counted(w)]);
    mixed([x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16), w ^ (w >> 16)])
}

#[inline(always)]
fn counted(c: u32) -> u32 {
    c.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)
}

#[inline(always)]
fn mixed([x, y, z, w]: [u32; 4]) -> [u32; 4] {
    let x = x.wrapping_add(y.wrapping_mul(w));
    let y = y.wrapping_add(z.wrapping_mul(x));
    let z = z.wrapping_add(x.wrapping_mul(y));
    let w = w.wrapping_add(y.wrapping_mul(z));
    [x, y, z, w]
}

/// The top 24 bits of a word as a number in [0, 1).
#[inline(always)]
fn unit(word: u32) -> f32 {
    (word >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

/// SplitMix64's finaliser (Steele, Lea, Flood 2014): every input bit moves every output bit.
fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

fn fold(x: u64) -> u32 {
    // Truncation is the point: the low half of a mixed word.
    #[allow(clippy::cast_possible_truncation)]
    let low = x as u32;
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first two dimensions of 256 points fill each of 16x16 cells once: what makes them better than random.
    #[test]
    fn points_are_stratified() {
        for seed in 0..20 {
            let sampler = PixelSampler::new(seed, 3, 17, 5, 1);
            let mut cells = vec![0; 256];
            for i in 0..256 {
                let u = sampler.sample(i).next4();
                cells[(u[0] * 16.0) as usize * 16 + (u[1] * 16.0) as usize] += 1;
            }
            assert!(cells.iter().all(|c| *c == 1));
        }
    }

    /// Halves, neighbours, photos and seeds must not share numbers: the product of two independent uniform means has
    /// a known spread. 4000 pairs of 16-sample means; |correlation| < 4.5 / sqrt(4000) fails 7 times in a million.
    #[test]
    fn halves_and_pixels_are_uncorrelated() {
        let value = |s: PixelSampler| s.sample(0).next4()[2] - 0.5;
        let pairs: [&dyn Fn(u32) -> (PixelSampler, PixelSampler); 4] = [
            &|i| (PixelSampler::new(1, 0, i, 9, 0), PixelSampler::new(1, 0, i, 9, 1)),
            &|i| (PixelSampler::new(1, 0, i, 9, 0), PixelSampler::new(1, 0, i + 1, 9, 0)),
            &|i| (PixelSampler::new(1, 0, i, 9, 0), PixelSampler::new(1, 1, i, 9, 0)),
            &|i| (PixelSampler::new(1, 0, i, 9, 0), PixelSampler::new(2, 0, i, 9, 0)),
        ];
        for pair in pairs {
            let n = 4000;
            let sum: f32 = (0..n)
                .map(|i| {
                    let (a, b) = pair(i);
                    value(a) * value(b)
                })
                .sum();
            let correlation = sum / n as f32 * 12.0;
            assert!(correlation.abs() < 4.5 / (n as f32).sqrt(), "correlation {correlation}");
        }
    }

    /// Deep in a path the numbers are uniform and independent between neighbouring samples: mean, variance and lag-one
    /// correlation of 4 x 50 000 numbers within 4.5 standard errors (7 false alarms in a million, each).
    #[test]
    fn deep_numbers_are_uniform() {
        let deep = |index: u32| {
            let mut sampler = PixelSampler::new(3, 1, 20, 30, 0).sample(index);
            for _ in 0..SOBOL_GROUPS {
                sampler.next4();
            }
            sampler.next4()
        };
        let n = 50_000u32;
        for d in 0..4 {
            let x: Vec<f64> = (0..=n).map(|i| f64::from(deep(i)[d]) - 0.5).collect();
            let mean = |f: &dyn Fn(usize) -> f64| (0..n as usize).map(f).sum::<f64>() / f64::from(n);
            let bound = 4.5 / f64::from(n).sqrt();
            assert!(mean(&|i| x[i]).abs() < bound / 12f64.sqrt());
            assert!((mean(&|i| x[i] * x[i]) * 12.0 - 1.0).abs() < bound * 0.8f64.sqrt());
            assert!(mean(&|i| x[i] * x[i + 1] * 12.0).abs() < bound);
        }
    }

    #[test]
    fn sequences_aside_are_others() {
        let mut main = PixelSampler::new(1, 2, 3, 4, 0).sample(5);
        let all = [Aside::Choice, Aside::Glare, Aside::Dark, Aside::Below].map(|which| main.aside(which).next4());
        let own = main.next4();
        assert!(!all.contains(&own));
        assert!((1..all.len()).all(|k| !all[..k].contains(&all[k])));
    }

    #[test]
    fn deep_paths_and_long_sequences_do_not_repeat() {
        let pixel = PixelSampler::new(7, 0, 0, 0, 0);
        let mut deep = pixel.sample(0);
        let first = deep.next4();
        let later: Vec<[f32; 4]> = (0..200).map(|_| deep.next4()).collect();
        assert!(!later.contains(&first));
        assert_ne!(pixel.sample(0).next4(), pixel.sample(SEQUENCE).next4());
    }
}
