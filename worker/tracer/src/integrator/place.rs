//! The surfaces that a block of paths has come to, and the lights as seen from there: what shading them side by side needs.

// Several arrays at one index read better than nested zips.
#![allow(clippy::needless_range_loop)]

use crate::basis::Basis;
use crate::bsdf::Bsdf;
use crate::bvh::Hits;
use crate::geometry::{Geometry, Surfaces};
use crate::light::{Lamp, PhotoLights};
use crate::vectors::{BLOCK, Lanes, Vectors, lanes, positive};
use glam::Vec2;

/// Surfaces of one material, side by side.
pub struct Place {
    pub surfaces: Surfaces,
    x: Vectors,
    y: Vectors,
    /// Where the paths came from, in the shading frames.
    pub wo: Vectors,
    /// What the material needs to know of `wo`.
    pub through: Lanes,
    /// The lanes of those that are seen from their front.
    pub seen: u32,
}

impl Place {
    /// Where the rays of the lanes in `mask` hit, which run in `direction`.
    #[inline(always)]
    pub fn new(geometry: &Geometry, bsdf: &Bsdf, direction: &Vectors, hits: &Hits, mask: u32) -> Self {
        let mut surfaces = Surfaces::ZERO;
        geometry.surfaces(hits, mask, &mut surfaces);
        let (mut x, mut y, mut wo, mut through) = (Vectors::ZERO, Vectors::ZERO, Vectors::ZERO, [0.0; BLOCK]);
        for lane in 0..BLOCK {
            let basis = Basis::new(surfaces.normal.get(lane));
            x.set(lane, basis.x);
            y.set(lane, basis.y);
            wo.set(lane, basis.local(-direction.get(lane)));
        }
        bsdf.through(&wo, &mut through);
        let seen = mask & positive(&wo.z);
        Self { surfaces, x, y, wo, through, seen }
    }

    /// The shading frame of a lane.
    #[inline(always)]
    pub fn basis(&self, lane: usize) -> Basis {
        Basis { x: self.x.get(lane), y: self.y.get(lane), z: self.surfaces.normal.get(lane) }
    }
}

/// How a light lights a block.
pub struct Lit {
    pub direction: Vectors,
    /// 0 where no light comes from: the lamp is at the point itself, say.
    pub distance: Lanes,
    pub light: Vectors,
    /// Density over solid angle; 0 for a lamp, which no other strategy can hit.
    pub pdf: Lanes,
}

impl Lit {
    /// Not at all.
    pub const ZERO: Self =
        Self { direction: Vectors::ZERO, distance: [0.0; BLOCK], light: Vectors::ZERO, pdf: [0.0; BLOCK] };

    /// Sampled light number `index` as seen from the surfaces; `numbers` has two for each lane, which lamps do not look at.
    #[inline(always)]
    pub fn towards(&mut self, lights: &PhotoLights, index: usize, place: &Place, numbers: [&Lanes; 2]) {
        if let Some(lamp) = lights.lamp(index) {
            self.from(&lamp, &place.surfaces.position);
            return;
        }
        self.distance = [0.0; BLOCK];
        for lane in lanes(place.seen) {
            self.sample(lights, index, place, lane, Vec2::new(numbers[0][lane], numbers[1][lane]));
        }
    }

    /// The same of one lane.
    #[inline(always)]
    pub fn sample(&mut self, lights: &PhotoLights, index: usize, place: &Place, lane: usize, numbers: Vec2) {
        let Some((sample, _)) = lights.sample(index, place.surfaces.position.get(lane), numbers) else {
            self.distance[lane] = 0.0;
            return;
        };
        self.direction.set(lane, sample.direction);
        self.distance[lane] = sample.distance;
        self.light.set(lane, sample.emission.value);
        self.pdf[lane] = sample.pdf;
    }

    /// The light of `lamp` at some positions.
    #[inline(always)]
    fn from(&mut self, lamp: &Lamp, position: &Vectors) {
        self.pdf = [0.0; BLOCK];
        match lamp {
            Lamp::Point { position: place, intensity } => {
                for lane in 0..BLOCK {
                    let way = *place - position.get(lane);
                    let distance2 = way.length_squared();
                    let distance = distance2.sqrt();
                    self.direction.set(lane, way / distance);
                    self.light.set(lane, *intensity * (1.0 / distance2));
                    self.distance[lane] = if distance2 > f32::MIN_POSITIVE { distance } else { 0.0 };
                }
            }
            Lamp::Directional { towards, irradiance } => {
                for lane in 0..BLOCK {
                    self.direction.set(lane, *towards);
                    self.light.set(lane, *irradiance);
                    self.distance[lane] = f32::INFINITY;
                }
            }
        }
    }
}
