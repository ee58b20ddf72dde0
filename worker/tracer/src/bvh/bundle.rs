//! Up to sixteen rays side by side, and their hits: as vector instructions want them.

use super::ray::{Hit, Ray};
use crate::vectors::{ALL, BLOCK, Lanes, Vectors, equal, lanes};

/// Rays side by side. Their fields are those of [`Ray`].
#[derive(Debug, Clone, Copy)]
pub struct Bundle {
    pub origin: Vectors,
    pub direction: Vectors,
    pub t_min: Lanes,
    pub t_max: Lanes,
    /// Which lanes hold a ray, as bits; the others may hold anything.
    pub used: u32,
}

impl Bundle {
    /// No ray.
    pub const NONE: Self = Self {
        origin: Vectors::ZERO,
        direction: Vectors::ZERO,
        t_min: [0.0; BLOCK],
        t_max: [f32::INFINITY; BLOCK],
        used: 0,
    };

    /// The first sixteen of some rays.
    #[must_use]
    pub fn new(rays: &[Ray]) -> Self {
        let mut this = Self::NONE;
        for (lane, ray) in rays.iter().enumerate().take(BLOCK) {
            this.set(lane, ray);
        }
        this
    }

    /// Lets a lane hold a ray.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, ray: &Ray) {
        self.origin.set(lane, ray.origin);
        self.direction.set(lane, ray.direction);
        (self.t_min[lane], self.t_max[lane]) = (ray.t_min, ray.t_max);
        self.used |= 1 << lane;
    }

    /// The ray of a lane.
    #[inline(always)]
    #[must_use]
    pub fn ray(&self, lane: usize) -> Ray {
        let (origin, direction) = (self.origin.get(lane), self.direction.get(lane));
        Ray { origin, direction, t_min: self.t_min[lane], t_max: self.t_max[lane] }
    }

    /// The same rays, with a copy of the first that ends before it begins in the other lanes.
    #[inline(always)]
    #[must_use]
    pub fn filled(&self) -> Self {
        let mut this = *self;
        if self.used != ALL {
            let spare = self.ray(self.used.trailing_zeros() as usize % BLOCK);
            for lane in lanes(ALL & !self.used) {
                this.set(lane, &Ray { t_max: f32::NEG_INFINITY, ..spare });
            }
            this.used = self.used;
        }
        this
    }

    /// How many lanes hold a ray.
    #[inline(always)]
    #[must_use]
    pub fn count(&self) -> usize {
        self.used.count_ones() as usize
    }
}

/// The hits of a [`Bundle`].
#[derive(Debug, Clone, Copy)]
pub struct Hits {
    pub t: Lanes,
    pub u: Lanes,
    pub v: Lanes,
    /// [`Hits::MISS`] where a ray hits nothing.
    pub triangle: [u32; BLOCK],
}

impl Hits {
    /// No triangle's index.
    pub const MISS: u32 = u32::MAX;
    /// Nothing is hit.
    pub const NONE: Self = Self { t: [0.0; BLOCK], u: [0.0; BLOCK], v: [0.0; BLOCK], triangle: [Self::MISS; BLOCK] };

    /// The hit of a lane.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, lane: usize) -> Option<Hit> {
        let (t, u, v, triangle) = (self.t[lane], self.u[lane], self.v[lane], self.triangle[lane]);
        (triangle != Self::MISS).then_some(Hit { t, u, v, triangle })
    }

    /// Sets the hit of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, hit: Option<Hit>) {
        match hit {
            Some(Hit { t, u, v, triangle }) => {
                (self.t[lane], self.u[lane], self.v[lane], self.triangle[lane]) = (t, u, v, triangle);
            }
            None => self.triangle[lane] = Self::MISS,
        }
    }

    /// The lanes that hit something, as bits.
    #[inline(always)]
    #[must_use]
    pub fn found(&self) -> u32 {
        ALL & !equal(&self.triangle, Self::MISS)
    }
}
