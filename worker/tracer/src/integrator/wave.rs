//! What paths do behind their first surfaces: those of many pixels that have come to one material at the same bounce are
//! followed side by side. The bits are those of single paths.

// Several arrays at one index read better than nested zips.
#![allow(clippy::needless_range_loop)]

use super::place::{Lit, Place};
use super::roulette::survival;
use super::{Start, Tally, World, direct_weight, trace};
use crate::bsdf::{Bsdf, Evaluations};
use crate::bvh::{Bundle, Hits};
use crate::sampler::{BLOCK, Keys, Sampler};
use crate::vectors::{Lanes, Vectors, lanes, positive};
use glam::{Vec2, Vec3};

/// Fewer paths than this are quicker one by one.
const FEW: usize = 4;

/// A path that goes on.
#[derive(Clone, Copy)]
pub struct Path {
    pub start: Start,
    /// The path's numbers, from the first on.
    pub sampler: Sampler<'static>,
    /// Where its radiance belongs.
    pub slot: usize,
}

/// Paths that go on, by the material that they have come to.
#[derive(Default)]
pub struct Waves {
    now: Vec<Vec<Path>>,
    next: Vec<Vec<Path>>,
}

impl Waves {
    /// None, in a scene of so many materials.
    #[must_use]
    pub fn new(shaders: usize) -> Self {
        Self { now: vec![Vec::new(); shaders], next: vec![Vec::new(); shaders] }
    }

    /// Takes a path from behind its first surface; one that blocks have no loops for is followed to its end at once.
    #[inline]
    pub fn push(&mut self, world: &World<'_>, path: Path, radiance: &mut [Vec3]) {
        if world.lights.can_be_met() && arrives(world, &path.start, &mut radiance[path.slot]) {
            return;
        }
        if let Some(hit) = &path.start.hit {
            let shader = world.shader_of[world.geometry.part_of(hit.triangle)];
            if world.shaders[shader].many().is_some() {
                self.next[shader].push(path);
                return;
            }
        }
        path.alone(world, radiance);
    }

    /// Follows all paths to their ends.
    pub fn follow(&mut self, world: &World<'_>, radiance: &mut [Vec3]) {
        while self.next.iter().any(|paths| !paths.is_empty()) {
            std::mem::swap(&mut self.now, &mut self.next);
            for shader in 0..self.now.len() {
                let mut paths = std::mem::take(&mut self.now[shader]);
                for block in paths.chunks(BLOCK) {
                    match world.shaders[shader].many() {
                        Some(bsdf) if block.len() >= FEW => bounce(world, bsdf, block, radiance, self),
                        _ => block.iter().for_each(|path| path.alone(world, radiance)),
                    }
                }
                paths.clear();
                self.now[shader] = paths;
            }
        }
    }
}

impl Path {
    fn alone(&self, world: &World<'_>, radiance: &mut [Vec3]) {
        alone(world, self.start, self.sampler, &mut radiance[self.slot]);
    }
}

/// As [`Start::arrives`], where radiance alone is wanted.
#[inline]
pub fn arrives(world: &World<'_>, start: &Start, radiance: &mut Vec3) -> bool {
    let mut tally = Tally { radiance: *radiance, derivatives: &mut [] };
    let ends = start.arrives(world, &mut tally);
    *radiance = tally.radiance;
    ends
}

/// Follows one path to its end. `numbers` are the path's from the first on.
pub fn alone(world: &World<'_>, start: Start, mut numbers: Sampler<'_>, radiance: &mut Vec3) {
    (0..start.groups).for_each(|_| numbers.skip());
    let mut tally = Tally { radiance: *radiance, derivatives: &mut [] };
    trace::<true>(world, start, &mut numbers, &mut [], &mut tally);
    *radiance = tally.radiance;
}

fn bounce(world: &World<'_>, bsdf: &Bsdf, paths: &[Path], radiance: &mut [Vec3], waves: &mut Waves) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has what the function enables.
        #[allow(unsafe_code)]
        return unsafe { bounce_avx2(world, bsdf, paths, radiance, waves) };
    }
    bounce_lanes(world, bsdf, paths, radiance, waves);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn bounce_avx2(world: &World<'_>, bsdf: &Bsdf, paths: &[Path], radiance: &mut [Vec3], waves: &mut Waves) {
    bounce_lanes(world, bsdf, paths, radiance, waves);
}

/// What [`trace`] does at a surface behind the first, for at most [`BLOCK`] paths of one bounce that have come to
/// surfaces of one material.
#[inline(always)]
fn bounce_lanes(world: &World<'_>, bsdf: &Bsdf, paths: &[Path], radiance: &mut [Vec3], waves: &mut Waves) {
    let (mut direction, mut hits, mut keys) = (Vectors::ZERO, Hits::NONE, Keys::ZERO);
    let (mut throughput, mut proposed) = (Vectors::ZERO, Vectors::ZERO);
    for (lane, path) in paths.iter().enumerate().take(BLOCK) {
        direction.set(lane, path.start.ray.direction);
        hits.set(lane, path.start.hit);
        keys.set(lane, &path.sampler);
        throughput.set(lane, path.start.throughput);
        proposed.set(lane, path.start.proposed);
    }
    let mask = u32::MAX >> (32 - paths.len().min(BLOCK));
    let Start { groups, bounce, .. } = paths[0].start;
    let place = Place::new(world.geometry, bsdf, &direction, &hits, mask);
    let (mut numbers, mut towards) = ([[0.0; BLOCK]; 4], [[0.0; BLOCK]; 4]);
    keys.numbers(groups, &mut numbers);

    let mut through_i = [0.0; BLOCK];
    let (mut wi, mut found) = (Vectors::ZERO, Evaluations::ZERO);
    let mut rays = Bundle::NONE;
    let lights = world.lights.sampled();
    let pick = if lights == 0 { 1.0 } else { 1.0 / lights as f32 };
    if lights > 0 {
        if lights > 1 || world.lights.need_numbers() {
            keys.numbers(groups + 1, &mut towards);
        }
        let lit = choose(world, &place, &towards);
        for lane in 0..BLOCK {
            wi.set(lane, place.basis(lane).local(lit.direction.get(lane)));
        }
        bsdf.through(&wi, &mut through_i);
        bsdf.evaluate_many(&place.wo, &wi, [&place.through, &through_i], &mut found);
        let used = place.seen & found.value.nonzero() & positive(&wi.z) & positive(&lit.distance);
        place.surfaces.rays_to(&lit.direction, &lit.distance, &mut rays);
        for lane in lanes(used) {
            let shadow = rays.ray(lane);
            if !world.geometry.occluded(&shadow) && !world.lights.in_the_way(&shadow) {
                let weight = direct_weight(lit.pdf[lane], pick, Some(found.pdf[lane]));
                let light = found.value.get(lane) * weight * lit.light.get(lane);
                radiance[paths[lane].slot] += throughput.get(lane) * light;
            }
        }
    }

    bsdf.sample_many(&place.wo, &numbers, &place.through, &mut wi);
    bsdf.through(&wi, &mut through_i);
    bsdf.evaluate_many(&place.wo, &wi, [&place.through, &through_i], &mut found);
    let mut leaving = Vectors::ZERO;
    let mut used = place.seen & positive(&wi.z) & positive(&found.pdf);
    for lane in 0..BLOCK {
        let (value, pdf) = (found.value.get(lane), found.pdf[lane]);
        let mut through = proposed.get(lane) * (value / pdf);
        let survival = survival(bounce, through);
        through /= survival;
        used &= !(u32::from(numbers[3][lane] >= survival) << lane);
        proposed.set(lane, through);
        throughput.set(lane, throughput.get(lane) * (value * (1.0 / (pdf * survival))));
        leaving.set(lane, place.basis(lane).world(wi.get(lane)));
    }
    place.surfaces.rays(&leaving, &mut rays);
    rays.used = used & throughput.nonzero();
    if rays.used == 0 {
        return;
    }
    let mut next = Hits::NONE;
    world.geometry.closest_stream(&rays, &mut next);
    let alive = if world.lights.can_be_met() { rays.used } else { rays.used & next.found() };
    for lane in lanes(alive) {
        let start = Start {
            ray: rays.ray(lane),
            hit: next.get(lane),
            bounce: bounce + 1,
            throughput: throughput.get(lane),
            proposed: proposed.get(lane),
            arrival: Some((found.pdf[lane], pick)),
            groups: groups + 2,
            branch: 0,
        };
        waves.push(world, Path { start, ..paths[lane] }, radiance);
    }
}

/// The light that each path's third number chooses, which there must be, by its first two.
#[inline(always)]
fn choose(world: &World<'_>, place: &Place, numbers: &[Lanes; 4]) -> Lit {
    let lights = world.lights.sampled();
    let mut lit = Lit::ZERO;
    if lights == 1 {
        lit.towards(world.lights, 0, place, [&numbers[0], &numbers[1]]);
        return lit;
    }
    for lane in lanes(place.seen) {
        let index = ((numbers[2][lane] * lights as f32) as usize).min(lights - 1);
        lit.sample(world.lights, index, place, lane, Vec2::new(numbers[0][lane], numbers[1][lane]));
    }
    lit
}
