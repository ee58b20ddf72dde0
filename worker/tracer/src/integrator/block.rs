//! The first surfaces of a block of paths through one pixel: the bits of single paths, in loops that vectorise and with
//! rays that share a walk through the hierarchy.
//!
//! Plain materials under a few point and directional lights, no derivative along the path. What is beyond that goes
//! on, or starts, as a single path.

use super::{ALL_LIGHTS, Start, World};
use crate::basis::Basis;
use crate::bsdf::Evaluations;
use crate::bvh::{Hit, Ray};
use crate::geometry::Surface;
use crate::light::Lamp;
use crate::sampler::Block;
use crate::vectors::{BLOCK, Lanes, Vectors};
use crate::{bsdf::Bsdf, light::PhotoLights};
use glam::Vec3;

/// What a block of paths has found at its first surfaces, and where it goes from there.
pub struct Paths {
    /// Radiance so far.
    pub radiance: [Vec3; BLOCK],
    /// Where a path that may find more goes on; a path that is still a camera ray has found nothing yet.
    pub rest: [Option<Start>; BLOCK],
}

impl Paths {
    /// Nothing found, nowhere to go.
    pub const NONE: Self = Self { radiance: [Vec3::ZERO; BLOCK], rest: [None; BLOCK] };
}

/// Whether blocks of paths can be lit by these lights.
pub fn lights_blocks(lights: &PhotoLights) -> bool {
    let few = lights.sampled() <= ALL_LIGHTS && !lights.has_spheres();
    few && (0..lights.sampled()).all(|index| lights.lamp(index).is_some())
}

/// Follows camera rays, whose first hits are known, through their first surfaces. Group 1 of `numbers` must be ready,
/// [`lights_blocks`] hold.
pub fn trace_block(world: &World<'_>, rays: &[Ray], hits: &[Option<Hit>; BLOCK], numbers: &Block, paths: &mut Paths) {
    *paths = Paths::NONE;
    let mut todo = 0u32;
    for (lane, ray) in rays.iter().enumerate().take(BLOCK) {
        if hits[lane].is_some() {
            todo |= 1 << lane;
        } else if world.lights.has_environments() {
            paths.rest[lane] = Some(Start::camera(*ray, None));
        }
    }
    let mut shaders = [usize::MAX; BLOCK];
    for lane in lanes(todo) {
        if let Some(hit) = &hits[lane] {
            shaders[lane] = world.shader_of[world.geometry.object(hit)];
        }
    }
    while todo != 0 {
        let shader = shaders[todo.trailing_zeros() as usize % BLOCK];
        let mask = lanes(todo).filter(|lane| shaders[*lane] == shader).fold(0u32, |mask, lane| mask | 1 << lane);
        todo &= !mask;
        match world.shaders[shader].many() {
            Some(bsdf) => shade(world, bsdf, rays, hits, mask, numbers, paths),
            None => {
                for lane in lanes(mask) {
                    paths.rest[lane] = Some(Start::camera(rays[lane], hits[lane]));
                }
            }
        }
    }
}

fn shade(
    world: &World<'_>,
    bsdf: &Bsdf,
    rays: &[Ray],
    hits: &[Option<Hit>; BLOCK],
    mask: u32,
    numbers: &Block,
    paths: &mut Paths,
) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has what the function enables.
        #[allow(unsafe_code)]
        return unsafe { shade_avx2(world, bsdf, rays, hits, mask, numbers, paths) };
    }
    shade_lanes(world, bsdf, rays, hits, mask, numbers, paths);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn shade_avx2(
    world: &World<'_>,
    bsdf: &Bsdf,
    rays: &[Ray],
    hits: &[Option<Hit>; BLOCK],
    mask: u32,
    numbers: &Block,
    paths: &mut Paths,
) {
    shade_lanes(world, bsdf, rays, hits, mask, numbers, paths);
}

/// The lanes of a mask.
#[inline(always)]
fn lanes(mask: u32) -> impl Iterator<Item = usize> {
    (0..BLOCK).filter(move |lane| mask >> lane & 1 != 0)
}

/// Shading frames side by side.
struct Frames {
    x: Vectors,
    y: Vectors,
    z: Vectors,
}

impl Frames {
    #[inline(always)]
    fn get(&self, lane: usize) -> Basis {
        Basis { x: self.x.get(lane), y: self.y.get(lane), z: self.z.get(lane) }
    }
}

#[inline(always)]
fn shade_lanes(
    world: &World<'_>,
    bsdf: &Bsdf,
    rays: &[Ray],
    hits: &[Option<Hit>; BLOCK],
    mask: u32,
    numbers: &Block,
    paths: &mut Paths,
) {
    let mut surfaces = Surfaces { position: Vectors::ZERO, face: Vectors::ZERO, margin: [0.0; BLOCK] };
    let (mut back, mut wo) = (Vectors::ZERO, Vectors::ZERO);
    let mut frames = Frames { x: Vectors::ZERO, y: Vectors::ZERO, z: Vectors::ZERO };
    for lane in lanes(mask) {
        if let Some(hit) = &hits[lane] {
            let surface = world.geometry.surface(hit);
            surfaces.position.set(lane, surface.position);
            surfaces.face.set(lane, surface.face);
            surfaces.margin[lane] = surface.margin;
            frames.z.set(lane, surface.normal);
            back.set(lane, -rays[lane].direction);
        }
    }
    for lane in 0..BLOCK {
        let basis = Basis::new(frames.z.get(lane));
        frames.x.set(lane, basis.x);
        frames.y.set(lane, basis.y);
        wo.set(lane, basis.local(back.get(lane)));
    }
    let (mut through_o, mut through_i) = ([0.0; BLOCK], [0.0; BLOCK]);
    bsdf.through(&wo, &mut through_o);
    let seen = lanes(mask).filter(|lane| wo.get(*lane).z > 0.0).fold(0u32, |mask, lane| mask | 1 << lane);

    let (mut wi, mut found) = (Vectors::ZERO, Evaluations::ZERO);
    for index in 0..world.lights.sampled() {
        let Some(lamp) = world.lights.lamp(index) else { continue };
        let mut lit = Lit { direction: Vectors::ZERO, distance: [0.0; BLOCK], light: Vectors::ZERO };
        lit.from(&lamp, &surfaces.position);
        for lane in 0..BLOCK {
            wi.set(lane, frames.get(lane).local(lit.direction.get(lane)));
        }
        bsdf.through(&wi, &mut through_i);
        bsdf.evaluate_many(&wo, &wi, [&through_o, &through_i], &mut found);
        let (mut shadows, mut owners, mut count) = ([Ray::NONE; BLOCK], [0; BLOCK], 0);
        for lane in lanes(seen) {
            if wi.get(lane).z > 0.0 && lit.distance[lane] > 0.0 && found.value.get(lane) != Vec3::ZERO {
                shadows[count] = surfaces.get(lane).ray_to(lit.direction.get(lane), lit.distance[lane]);
                owners[count] = lane;
                count += 1;
            }
        }
        let mut blocked = [false; BLOCK];
        world.geometry.occluded_packet(&shadows[..count], &mut blocked[..count]);
        for (lane, blocked) in owners[..count].iter().zip(blocked) {
            if !blocked {
                paths.radiance[*lane] += found.value.get(*lane) * lit.light.get(*lane);
            }
        }
    }

    bsdf.sample_many(&wo, numbers.group(1), &through_o, &mut wi);
    bsdf.through(&wi, &mut through_i);
    bsdf.evaluate_many(&wo, &wi, [&through_o, &through_i], &mut found);
    // The camera's, the surface's two, and one for each light beyond two.
    let groups = 3 + world.lights.sampled().saturating_sub(2) as u32;
    let (mut leaving, mut owners, mut count) = ([Ray::NONE; BLOCK], [0; BLOCK], 0);
    for lane in lanes(seen) {
        let (drawn, value, pdf) = (wi.get(lane), found.value.get(lane), found.pdf[lane]);
        if drawn.z > 0.0 && pdf > 0.0 && value * (1.0 / pdf) != Vec3::ZERO {
            leaving[count] = surfaces.get(lane).ray(frames.get(lane).world(drawn), f32::INFINITY);
            owners[count] = lane;
            count += 1;
        }
    }
    let mut next = [None; BLOCK];
    world.geometry.closest_stream(&leaving[..count], &mut next[..count]);
    for ((&lane, ray), hit) in owners[..count].iter().zip(leaving).zip(next) {
        if hit.is_some() || world.lights.has_environments() {
            let (value, pdf) = (found.value.get(lane), found.pdf[lane]);
            let (throughput, proposed) = (value * (1.0 / pdf), value / pdf);
            let arrival = Some((pdf, 1.0));
            paths.rest[lane] = Some(Start { ray, hit, bounce: 1, throughput, proposed, arrival, groups });
        }
    }
}

/// Surfaces side by side.
struct Surfaces {
    position: Vectors,
    face: Vectors,
    margin: Lanes,
}

impl Surfaces {
    /// One of them, without what a shader needs.
    #[inline(always)]
    fn get(&self, lane: usize) -> Surface {
        let (position, face, margin) = (self.position.get(lane), self.face.get(lane), self.margin[lane]);
        Surface { position, face, normal: face, object: 0, margin }
    }
}

/// How one lamp lights a block.
struct Lit {
    direction: Vectors,
    /// 0 where the lamp is at the point itself.
    distance: Lanes,
    light: Vectors,
}

impl Lit {
    #[inline(always)]
    fn from(&mut self, lamp: &Lamp, position: &Vectors) {
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
