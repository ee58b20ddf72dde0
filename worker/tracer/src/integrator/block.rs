//! The first surfaces of a block of camera rays through one pixel, and the paths that go on from there: the bits of single paths, in loops that vectorise and with
//! rays that share a walk through the hierarchy.
//!
//! Plain materials under a few lights, no derivative along the path. What is beyond that goes
//! on, or starts, as a single path.

// Several arrays at one index read better than nested zips.
#![allow(clippy::needless_range_loop)]

use super::place::{Lit, Place};
use super::wave::{Path, Waves, alone, arrives};
use super::{ALL_LIGHTS, SHARE, Start, World, direct_weight};
use crate::bsdf::{Bsdf, Evaluations};
use crate::bvh::{Bundle, Hits};
use crate::light::PhotoLights;
use crate::sampler::{Branches, Keys, PixelSampler, SPLIT, Sampler};
use crate::vectors::{BLOCK, Vectors, equal, lanes, positive};
use glam::Vec3;

/// A block of camera rays through one pixel.
pub struct First<'a> {
    /// The camera rays.
    pub rays: &'a Bundle,
    /// What they hit first.
    pub hits: &'a Hits,
    /// The numbers of the paths from there, of which group 1 is ready where anything is hit, group 2 if the lights need numbers.
    pub branches: &'a Branches,
    /// The pixel.
    pub sampler: PixelSampler,
    /// The first camera ray's sample; the others follow it.
    pub sample: u32,
    /// Where the radiance of the first path belongs; the others follow it, [`SPLIT`] for each camera ray.
    pub slot: usize,
}

/// Whether blocks of paths can be lit by these lights.
pub fn lights_blocks(lights: &PhotoLights) -> bool {
    lights.sampled() <= ALL_LIGHTS
}

/// Follows camera rays through their first surfaces: adds what they find to `radiance`, which is zero, and puts paths
/// that may find more into `waves`. [`lights_blocks`] must hold.
pub fn first_surfaces(world: &World<'_>, block: &First<'_>, radiance: &mut [Vec3], waves: &mut Waves) {
    let mut todo = block.hits.found() & block.rays.used;
    if world.lights.can_be_met() {
        for lane in lanes(block.rays.used) {
            let start = Start::camera(block.rays.ray(lane), block.hits.get(lane));
            if arrives(world, &start, &mut radiance[block.slot + lane * SPLIT as usize]) {
                todo &= !(1 << lane);
            }
        }
    }
    let mut shaders = [u32::MAX; BLOCK];
    for lane in lanes(todo) {
        shaders[lane] = world.shader_of[world.geometry.part_of(block.hits.triangle[lane])] as u32;
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
    /// The numbers of path number `path` of the block.
    #[inline(always)]
    fn sampler(&self, path: usize) -> Sampler<'static> {
        let path = path as u32;
        self.sampler.branch(self.sample + path / SPLIT, path % SPLIT)
    }

    /// Follows the paths of one camera ray.
    fn alone(&self, world: &World<'_>, lane: usize, radiance: &mut [Vec3]) {
        for branch in 0..SPLIT {
            let path = lane * SPLIT as usize + branch as usize;
            let start = Start::branch(self.rays.ray(lane), self.hits.get(lane), branch);
            let (block, at) = self.branches.of(lane, branch);
            alone(world, start, self.sampler(path).from(block, at), &mut radiance[self.slot + path]);
        }
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
    let lights = world.lights.sampled();
    if (0..lights).any(|index| world.lights.is_fixed(index)) {
        let place = Place::new(world.geometry, bsdf, &block.rays.direction, block.hits, mask);
        for index in (0..lights).filter(|index| world.lights.is_fixed(*index)) {
            let mut lit = Lit::ZERO;
            lit.towards(world.lights, index, &place, [&[0.0; BLOCK]; 2]);
            shine(world, bsdf, &place, &lit, 1.0, |lane| block.slot + lane * SPLIT as usize, radiance);
        }
    }
    for part in 0..SPLIT as usize {
        branch_lanes(world, bsdf, block, mask, part, radiance, waves);
    }
}

/// Adds what a light sends to surfaces, each path being worth `share` of its slot.
#[inline(always)]
fn shine(
    world: &World<'_>,
    bsdf: &Bsdf,
    place: &Place,
    lit: &Lit,
    share: f32,
    slot: impl Fn(usize) -> usize,
    radiance: &mut [Vec3],
) {
    let (mut through_i, mut wi, mut found) = ([0.0; BLOCK], Vectors::ZERO, Evaluations::ZERO);
    let mut rays = Bundle::NONE;
    for lane in 0..BLOCK {
        wi.set(lane, place.basis(lane).local(lit.direction.get(lane)));
    }
    bsdf.through(&wi, &mut through_i);
    bsdf.evaluate_many(&place.wo, &wi, [&place.through, &through_i], &mut found);
    place.surfaces.rays_to(&lit.direction, &lit.distance, &mut rays);
    rays.used = place.seen & found.value.nonzero() & positive(&wi.z) & positive(&lit.distance);
    let free = rays.used & !world.geometry.occluded_bundle(&rays);
    for lane in lanes(free) {
        if !world.lights.in_the_way(&rays.ray(lane)) {
            let weight = direct_weight(lit.pdf[lane], 1.0, Some(found.pdf[lane]));
            radiance[slot(lane)] += share * (found.value.get(lane) * weight * lit.light.get(lane));
        }
    }
}

/// The `part`-th of [`SPLIT`] blocks of the paths that go on from the camera rays in `mask`.
#[inline(always)]
fn branch_lanes(
    world: &World<'_>,
    bsdf: &Bsdf,
    block: &First<'_>,
    mask: u32,
    part: usize,
    radiance: &mut [Vec3],
    waves: &mut Waves,
) {
    let (mut direction, mut hits, mut used) = (Vectors::ZERO, Hits::NONE, 0);
    for lane in 0..BLOCK {
        let ray = (part * BLOCK + lane) / SPLIT as usize;
        direction.set(lane, block.rays.direction.get(ray));
        hits.set(lane, block.hits.get(ray));
        used |= (mask >> ray & 1) << lane;
    }
    if used == 0 {
        return;
    }
    let place = Place::new(world.geometry, bsdf, &direction, &hits, used);
    let numbers = block.branches.part(part);
    let slot = block.slot + part * BLOCK;
    for index in (0..world.lights.sampled()).filter(|index| !world.lights.is_fixed(*index)) {
        let mut lit = Lit::ZERO;
        if index < 2 {
            let [a, b, c, d] = numbers.group(2);
            lit.towards(world.lights, index, &place, if index == 0 { [a, b] } else { [c, d] });
        } else {
            let (mut keys, mut fresh) = (Keys::ZERO, [[0.0; BLOCK]; 4]);
            (0..BLOCK).for_each(|lane| keys.set(lane, &block.sampler(part * BLOCK + lane)));
            keys.numbers(1 + index as u32, &mut fresh);
            lit.towards(world.lights, index, &place, [&fresh[0], &fresh[1]]);
        }
        shine(world, bsdf, &place, &lit, SHARE, |lane| slot + lane, radiance);
    }

    let (mut through_i, mut wi, mut found) = ([0.0; BLOCK], Vectors::ZERO, Evaluations::ZERO);
    bsdf.sample_many(&place.wo, numbers.group(1), &place.through, &mut wi);
    bsdf.through(&wi, &mut through_i);
    bsdf.evaluate_many(&place.wo, &wi, [&place.through, &through_i], &mut found);
    let (mut leaving, mut weight, mut rays) = (Vectors::ZERO, Vectors::ZERO, Bundle::NONE);
    let used = place.seen & positive(&wi.z) & positive(&found.pdf);
    for lane in 0..BLOCK {
        leaving.set(lane, place.basis(lane).world(wi.get(lane)));
        weight.set(lane, SHARE * (found.value.get(lane) * (1.0 / found.pdf[lane])));
    }
    place.surfaces.rays(&leaving, &mut rays);
    rays.used = used & weight.nonzero();
    let mut next = Hits::NONE;
    world.geometry.closest_stream(&rays, &mut next);
    // The camera's, the surface's two, and one for each light beyond two.
    let groups = 3 + world.lights.sampled().saturating_sub(2) as u32;
    let alive = if world.lights.can_be_met() { rays.used } else { rays.used & next.found() };
    for lane in lanes(alive) {
        let (throughput, proposed) = (weight.get(lane), found.value.get(lane) / found.pdf[lane]);
        let (ray, hit, arrival) = (rays.ray(lane), next.get(lane), Some((found.pdf[lane], 1.0)));
        let start = Start { ray, hit, bounce: 1, throughput, proposed, arrival, groups, branch: 0 };
        waves.push(world, Path { start, sampler: block.sampler(part * BLOCK + lane), slot: slot + lane }, radiance);
    }
}
