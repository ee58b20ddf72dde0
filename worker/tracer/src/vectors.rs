//! Numbers and vectors of a block of paths side by side, so that loops over them vectorise.

// Several arrays at one index read better than nested zips.
#![allow(clippy::needless_range_loop)]

pub use crate::sampler::{BLOCK, Lanes};
use glam::Vec3;

/// The mask of all lanes.
pub const ALL: u32 = u32::MAX >> (32 - BLOCK);

/// The lanes of a mask.
#[derive(Debug, Clone, Copy)]
pub struct LanesOf(u32);

/// The lanes of a mask, one after the other.
#[inline(always)]
#[must_use]
pub fn lanes(mask: u32) -> LanesOf {
    LanesOf(mask & ALL)
}

impl Iterator for LanesOf {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lane = self.0.trailing_zeros() as usize % BLOCK;
        self.0 &= self.0 - 1;
        Some(lane)
    }
}

// Loops, where a fold would read better: what is not inlined into a function that enables AVX2 does without it.

/// The lanes that hold a positive number, as bits.
#[inline(always)]
#[must_use]
pub fn positive(numbers: &Lanes) -> u32 {
    let mut bits = 0;
    for lane in 0..BLOCK {
        bits |= u32::from(numbers[lane] > 0.0) << lane;
    }
    bits
}

/// The lanes that hold a certain word, as bits.
#[inline(always)]
#[must_use]
pub fn equal(words: &[u32; BLOCK], word: u32) -> u32 {
    let mut bits = 0;
    for lane in 0..BLOCK {
        bits |= u32::from(words[lane] == word) << lane;
    }
    bits
}

/// One vector for each path of a block.
#[derive(Debug, Clone, Copy)]
pub struct Vectors {
    pub x: Lanes,
    pub y: Lanes,
    pub z: Lanes,
}

impl Vectors {
    /// All zero.
    pub const ZERO: Self = Self { x: [0.0; BLOCK], y: [0.0; BLOCK], z: [0.0; BLOCK] };

    /// The same for every path.
    #[inline(always)]
    #[must_use]
    pub fn splat(v: Vec3) -> Self {
        Self { x: [v.x; BLOCK], y: [v.y; BLOCK], z: [v.z; BLOCK] }
    }

    /// The lanes in which it is not zero, as bits.
    #[inline(always)]
    #[must_use]
    pub fn nonzero(&self) -> u32 {
        let mut bits = 0;
        for lane in 0..BLOCK {
            bits |= u32::from((self.x[lane] != 0.0) | (self.y[lane] != 0.0) | (self.z[lane] != 0.0)) << lane;
        }
        bits
    }

    /// That of one path.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Changes that of one path.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (v.x, v.y, v.z);
    }
}
