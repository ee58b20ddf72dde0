//! Numbers and vectors of a block of paths side by side, so that loops over them vectorise.

pub use crate::sampler::{BLOCK, Lanes};
use glam::Vec3;

/// One vector for each path of a block.
#[derive(Debug, Clone, Copy)]
pub struct Vectors {
    x: Lanes,
    y: Lanes,
    z: Lanes,
}

impl Vectors {
    /// All zero.
    pub const ZERO: Self = Self { x: [0.0; BLOCK], y: [0.0; BLOCK], z: [0.0; BLOCK] };

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
