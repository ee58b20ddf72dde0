//! The Sobol points of many samples of one pixel at a time: the bits of `sobol_burley::sample_4d`, several times sooner.

use super::{PixelSampler, SEQUENCE, SOBOL_GROUPS, SPLIT, Sampler, pcg4d, unit};
use sobol_burley::parts::{hash, owen_scramble_rev, sobol_rev, u32_to_f32_norm};
use sobol_burley::sample_4d;
use std::sync::LazyLock;

/// Samples that are taken together.
pub const BLOCK: usize = 16;
/// One number for each sample of a block.
pub type Lanes = [f32; BLOCK];

/// Bits of a sample's index.
const BITS: usize = SEQUENCE.trailing_zeros() as usize;

/// By group and bit of the index, highest first: what that bit adds to each of the four dimensions, bits reversed.
static VECTORS: LazyLock<[[[u32; 4]; BITS]; SOBOL_GROUPS as usize]> = LazyLock::new(|| {
    std::array::from_fn(|group| {
        std::array::from_fn(|bit| std::array::from_fn(|d| sobol_rev(1 << (31 - bit), (group * 4 + d) as u32)))
    })
});

/// What the scramble of each of four dimensions is mixed with.
const SALTS: [u32; 4] = [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8];

/// The first groups of numbers of [`BLOCK`] successive samples.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    groups: [[Lanes; 4]; SOBOL_GROUPS as usize],
    /// Groups that have been filled.
    pub ready: u32,
}

impl Block {
    /// Without any number.
    #[must_use]
    pub fn new() -> Self {
        Self { groups: [[[0.0; BLOCK]; 4]; SOBOL_GROUPS as usize], ready: 0 }
    }

    /// The four dimensions of a group, which must be ready.
    #[inline]
    #[must_use]
    pub fn group(&self, group: u32) -> &[Lanes; 4] {
        &self.groups[group as usize]
    }

    /// Fills the next group of the samples from `first` on, for at least its first `dimensions`.
    pub fn fill(&mut self, pixel: &PixelSampler, first: u32, dimensions: usize) {
        let group = self.ready;
        let Some(numbers) = self.groups.get_mut(group as usize) else { return };
        self.ready += 1;
        let last = first.saturating_add(BLOCK as u32 - 1);
        if first / SEQUENCE != last / SEQUENCE || last == u32::MAX {
            for lane in 0..BLOCK {
                let sampler = pixel.sample(first.saturating_add(lane as u32));
                let point = sample_4d(sampler.index, group, sampler.scramble);
                for (numbers, x) in numbers.iter_mut().zip(point) {
                    numbers[lane] = x;
                }
            }
            return;
        }
        let start = pixel.sample(first);
        let used = &mut numbers[..dimensions.min(4)];
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function enables.
            #[allow(unsafe_code)]
            return unsafe { points_avx2(start.index, group, start.scramble, used) };
        }
        points(start.index, group, start.scramble, used);
    }
}

/// The numbers of the paths that go on from the first surfaces of [`BLOCK`] successive camera rays.
#[derive(Debug, Clone, Copy)]
pub struct Branches([Block; SPLIT as usize]);

impl Branches {
    /// Without any number.
    #[must_use]
    pub fn new() -> Self {
        Self([Block::new(); SPLIT as usize])
    }

    /// Fills groups 1 to `groups` for the camera rays from `first` on.
    pub fn fill(&mut self, pixel: &PixelSampler, first: u32, groups: u32) {
        for (k, block) in self.0.iter_mut().enumerate() {
            // Group 0 is the camera's, which nobody asks a branch for.
            block.ready = 1;
            let first = first.wrapping_mul(SPLIT).wrapping_add((k * BLOCK) as u32);
            (0..groups).for_each(|_| block.fill(pixel, first, 4));
        }
    }

    /// The block and the lane of path number `branch` from camera ray number `ray` of the block.
    #[inline]
    #[must_use]
    pub fn of(&self, ray: usize, branch: u32) -> (&Block, usize) {
        let path = ray * SPLIT as usize + branch as usize;
        (&self.0[path / BLOCK % SPLIT as usize], path % BLOCK)
    }

    /// [`BLOCK`] paths side by side: the `part`-th of [`SPLIT`] such blocks.
    #[inline]
    #[must_use]
    pub fn part(&self, part: usize) -> &Block {
        &self.0[part]
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn points_avx2(first: u32, group: u32, scramble: u32, numbers: &mut [Lanes]) {
    points(first, group, scramble, numbers);
}

/// Burley's points, lane by lane in loops that vectorise.
#[inline(always)]
fn points(first: u32, group: u32, scramble: u32, numbers: &mut [Lanes]) {
    let vectors = &VECTORS[group as usize];
    let shuffle = hash(scramble ^ 0x79c6_8e4a);
    let mut index = [0u32; BLOCK];
    for (lane, index) in index.iter_mut().enumerate() {
        *index = owen_scramble_rev((first + lane as u32).reverse_bits(), shuffle);
    }
    // The scramble of a bit depends on the bits above it alone: an aligned block differs in its last bits only.
    let own = if first.is_multiple_of(BLOCK as u32) { BLOCK.trailing_zeros() as usize } else { BITS };
    for (d, numbers) in numbers.iter_mut().enumerate() {
        let mut shared = 0;
        for (bit, vector) in vectors.iter().enumerate().skip(own) {
            shared ^= vector[d] & ((index[0] << bit).cast_signed() >> 31).cast_unsigned();
        }
        let mut point = [shared; BLOCK];
        for (bit, vector) in vectors.iter().enumerate().take(own) {
            for (point, index) in point.iter_mut().zip(&index) {
                // All ones where the bit is set.
                let mask = ((index << bit).cast_signed() >> 31).cast_unsigned();
                *point ^= vector[d] & mask;
            }
        }
        let scramble = hash(scramble.wrapping_mul(0x9c8f_2d3b) ^ group ^ SALTS[d]);
        for (number, point) in numbers.iter_mut().zip(point) {
            *number = u32_to_f32_norm(owen_scramble_rev(point, scramble).reverse_bits());
        }
    }
}

/// Samples of any pixels, for the numbers deep in their paths.
#[derive(Debug, Clone, Copy)]
pub struct Keys {
    index: [u32; BLOCK],
    scramble: [u32; BLOCK],
}

impl Keys {
    /// All zero.
    pub const ZERO: Self = Self { index: [0; BLOCK], scramble: [0; BLOCK] };

    /// Lets a lane be a sample.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, sample: &Sampler<'_>) {
        (self.index[lane], self.scramble[lane]) = (sample.index, sample.scramble);
    }

    /// The samples' numbers of a group behind the Sobol points.
    #[inline(always)]
    pub fn numbers(&self, group: u32, into: &mut [Lanes; 4]) {
        debug_assert!(group >= SOBOL_GROUPS, "these are counted numbers");
        // Over the lanes of several arrays, which is what vectorises.
        #[allow(clippy::needless_range_loop)]
        for lane in 0..BLOCK {
            let words = pcg4d([self.index[lane], group, self.scramble[lane], super::COUNTED]);
            (into[0][lane], into[1][lane]) = (unit(words[0]), unit(words[1]));
            (into[2][lane], into[3][lane]) = (unit(words[2]), unit(words[3]));
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn branches_give_the_numbers_of_single_samples() {
        let pixel = PixelSampler::new(5, 2, 9, 7, 1);
        let mut branches = Branches::new();
        // The last block crosses into another scramble.
        for first in [0, 16, 21, SEQUENCE / SPLIT - 5] {
            branches.fill(&pixel, first, 2);
            for (ray, branch) in (0..BLOCK).flat_map(|ray| (0..SPLIT).map(move |branch| (ray, branch))) {
                let mut single = pixel.branch(first + ray as u32, branch);
                let (block, lane) = branches.of(ray, branch);
                let mut ready = single.from(block, lane);
                single.skip();
                ready.skip();
                assert_eq!([single.next4(), single.next4()], [ready.next4(), ready.next4()]);
            }
        }
    }

    #[test]
    fn keys_give_the_numbers_of_single_samples() {
        let mut keys = Keys::ZERO;
        let sample = |lane: u32| PixelSampler::new(5, 2, lane, 7, 1).sample(3 * lane + 70_000);
        (0..BLOCK).for_each(|lane| keys.set(lane, &sample(lane as u32)));
        let mut numbers = [[0.0; BLOCK]; 4];
        for group in SOBOL_GROUPS..9 {
            keys.numbers(group, &mut numbers);
            for lane in 0..BLOCK {
                let mut single = sample(lane as u32);
                (0..group).for_each(|_| single.skip());
                assert_eq!(numbers.map(|d| d[lane]), single.next4());
            }
        }
    }

    #[test]
    fn blocks_hold_the_bits_of_single_samples() {
        for (seed, first) in [(1, 0), (2, 16), (3, 7), (4, SEQUENCE - 16), (5, SEQUENCE - 5), (6, 3 * SEQUENCE + 100)] {
            let pixel = PixelSampler::new(seed, 1, 12, 34, 1);
            let mut block = Block::new();
            for group in 0..SOBOL_GROUPS {
                block.fill(&pixel, first, 4);
                for lane in 0..BLOCK {
                    let mut single = pixel.sample(first + lane as u32);
                    (0..group).for_each(|_| single.skip());
                    assert_eq!(block.group(group).map(|d| d[lane]), single.next4(), "{first} {group} {lane}");
                }
            }
        }
    }
}
