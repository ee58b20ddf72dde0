//! The first surfaces of a block of paths through one pixel: the bits of single paths, in loops that vectorise and with
//! rays that share a walk through the hierarchy.
//!
//! Plain materials under a few point and directional lights, no derivative along the path. What is beyond that goes
//! on, or starts, as a single path.

// Several arrays at one index read better than nested zips.
#![allow(clippy::needless_range_loop)]

use super::place::{Lit, Place};
use super::wave::{Path, Waves, alone};
use super::{ALL_LIGHTS, Start, World};
use crate::bsdf::{Bsdf, Evaluations};
use crate::bvh::{Bundle, Hits};
use crate::light::PhotoLights;
use crate::sampler::{Block, PixelSampler, Sampler};
use crate::vectors::{BLOCK, Vectors, equal, lanes, positive};
use glam::Vec3;

/// A block of paths through one pixel.
pub struct First<'a> {
    /// The camera rays.
    pub rays: &'a Bundle,
    /// What they hit first.
    pub hits: &'a Hits,
    /// The paths' numbers, of which group 1 is ready where anything is hit.
    pub numbers: &'a Block,
    /// The pixel.
    pub sampler: PixelSampler,
    /// The first path's sample; the others follow it.
    pub sample: u32,
    /// Where the radiance of the first path belongs; the others follow it.
    pub slot: usize,
}

/// Whether blocks of paths can be lit by these lights.
pub fn lights_blocks(lights: &PhotoLights) -> bool {
    let few = lights.sampled() <= ALL_LIGHTS && !lights.has_spheres();
    few && (0..lights.sampled()).all(|index| lights.lamp(index).is_some())
}

/// Follows camera rays through their first surfaces: adds what they find to `radiance`, which is zero, and puts paths
/// that may find more into `waves`. [`lights_blocks`] must hold.
pub fn first_surfaces(world: &World<'_>, block: &First<'_>, radiance: &mut [Vec3], waves: &mut Waves) {
    let mut todo = block.hits.found() & block.rays.used;
    if world.lights.has_environments() {
        for lane in lanes(block.rays.used & !todo) {
            block.alone(world, lane, radiance);
        }
    }
    let mut shaders = [u32::MAX; BLOCK];
    for lane in lanes(todo) {
        shaders[lane] = world.shader_of[world.geometry.object_of(block.hits.triangle[lane])] as u32;
    }
    while todo != 0 {
        let shader = shaders[todo.trailing_zeros() as usize % BLOCK];
        let mask = todo & equal(&shaders, shader);
        todo &= !mask;
        let shader = shader as usize;
        match world.shaders[shader].many() {
            Some(bsdf) => shade(world, bsdf, block, mask, radiance, waves),
            None => {
                for lane in lanes(mask) {
                    block.alone(world, lane, radiance);
                }
            }
        }
    }
}

impl First<'_> {
    #[inline(always)]
    fn sampler(&self, lane: usize) -> Sampler<'static> {
        self.sampler.sample(self.sample + lane as u32)
    }

    /// Follows one path from the camera on.
    fn alone(&self, world: &World<'_>, lane: usize, radiance: &mut [Vec3]) {
        let start = Start::camera(self.rays.ray(lane), self.hits.get(lane));
        let numbers = self.sampler(lane).from(self.numbers, lane);
        alone(world, start, numbers, &mut radiance[self.slot + lane]);
    }
}

fn shade(world: &World<'_>, bsdf: &Bsdf, block: &First<'_>, mask: u32, radiance: &mut [Vec3], waves: &mut Waves) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has what the function enables.
        #[allow(unsafe_code)]
        return unsafe { shade_avx2(world, bsdf, block, mask, radiance, waves) };
    }
    shade_lanes(world, bsdf, block, mask, radiance, waves);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn shade_avx2(world: &World<'_>, bsdf: &Bsdf, block: &First<'_>, mask: u32, radiance: &mut [Vec3], waves: &mut Waves) {
    shade_lanes(world, bsdf, block, mask, radiance, waves);
}

#[inline(always)]
fn shade_lanes(world: &World<'_>, bsdf: &Bsdf, block: &First<'_>, mask: u32, radiance: &mut [Vec3], waves: &mut Waves) {
    let place = Place::new(world.geometry, bsdf, &block.rays.direction, block.hits, mask);
    let mut through_i = [0.0; BLOCK];
    let (mut wi, mut found) = (Vectors::ZERO, Evaluations::ZERO);
    let mut rays = Bundle::NONE;
    for index in 0..world.lights.sampled() {
        let Some(lamp) = world.lights.lamp(index) else { continue };
        let mut lit = Lit::ZERO;
        lit.from(&lamp, &place.surfaces.position);
        for lane in 0..BLOCK {
            wi.set(lane, place.basis(lane).local(lit.direction.get(lane)));
        }
        bsdf.through(&wi, &mut through_i);
        bsdf.evaluate_many(&place.wo, &wi, [&place.through, &through_i], &mut found);
        let used = place.seen & found.value.nonzero() & positive(&wi.z) & positive(&lit.distance);
        place.surfaces.rays_to(&lit.direction, &lit.distance, &mut rays);
        rays.used = used;
        let free = used & !world.geometry.occluded_bundle(&rays);
        for lane in lanes(free) {
            radiance[block.slot + lane] += found.value.get(lane) * lit.light.get(lane);
        }
    }

    bsdf.sample_many(&place.wo, block.numbers.group(1), &place.through, &mut wi);
    bsdf.through(&wi, &mut through_i);
    bsdf.evaluate_many(&place.wo, &wi, [&place.through, &through_i], &mut found);
    let (mut leaving, mut weight) = (Vectors::ZERO, Vectors::ZERO);
    let used = place.seen & positive(&wi.z) & positive(&found.pdf);
    for lane in 0..BLOCK {
        leaving.set(lane, place.basis(lane).world(wi.get(lane)));
        weight.set(lane, found.value.get(lane) * (1.0 / found.pdf[lane]));
    }
    place.surfaces.rays(&leaving, &mut rays);
    rays.used = used & weight.nonzero();
    let mut next = Hits::NONE;
    world.geometry.closest_stream(&rays, &mut next);
    // The camera's, the surface's two, and one for each light beyond two.
    let groups = 3 + world.lights.sampled().saturating_sub(2) as u32;
    let alive = if world.lights.has_environments() { rays.used } else { rays.used & next.found() };
    for lane in lanes(alive) {
        let (throughput, proposed) = (weight.get(lane), found.value.get(lane) / found.pdf[lane]);
        let (ray, hit, arrival) = (rays.ray(lane), next.get(lane), Some((found.pdf[lane], 1.0)));
        let start = Start { ray, hit, bounce: 1, throughput, proposed, arrival, groups };
        waves.push(world, Path { start, sampler: block.sampler(lane), slot: block.slot + lane }, radiance);
    }
}
