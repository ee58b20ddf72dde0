//! The path tracer: next-event estimation joined with BSDF sampling by multiple importance sampling (Veach's power
//! heuristic), Russian roulette, and forward derivatives carried along each path.
//!
//! Derivatives are detached: directions, densities and roulette are chosen from the current parameters and held fixed,
//! so that d radiance / d parameter is the estimator with d f in place of f, at no extra ray.

mod below;
mod block;
mod place;
mod probe;
mod roulette;
mod wave;

pub use block::{First, first_surfaces, lights_blocks};
pub use wave::Waves;

use crate::geometry::Geometry;
use crate::light::{Emission, LightSample, PhotoLights};
use crate::planes::PlaneIndex;
use crate::sampler::{Aside, SPLIT, Sampler};
use crate::shader::{MAX_SLOTS, Shader};
use crate::{bvh::Hit, bvh::Ray};
use glam::{Vec2, Vec3};
use roulette::survival;

/// At a path's first surface every light is sampled if there are no more than this; else, and later on, one at random.
const ALL_LIGHTS: usize = 4;

/// What one of the paths from a camera ray's first surface is worth.
const SHARE: f32 = 1.0 / SPLIT as f32;

/// What a path needs to know of the scene.
pub struct World<'a> {
    /// Triangles.
    pub geometry: &'a Geometry,
    /// Materials.
    pub shaders: &'a [Shader],
    /// The materials that choose directions and end paths: `shaders` itself, or, for central differences with the same
    /// paths, those of the point in the middle.
    pub proposals: &'a [Shader],
    /// Index into `shaders` by part.
    pub shader_of: &'a [usize],
    /// By how much a camera ray gets wider for each metre: see [`crate::camera::PhotoCamera::spread`].
    pub spread: f32,
    /// The photo's lights.
    pub lights: &'a PhotoLights,
}

/// A path's state: what light found from here on is worth, and how that depends on each parameter.
pub struct Carrier<'a> {
    throughput: Vec3,
    /// d throughput / d parameter by plane, all zero at the start; empty where no derivative is wanted.
    derivatives: &'a mut [Vec3],
}

/// Where a path's findings go.
pub struct Tally<'a> {
    /// Radiance, linear RGB.
    pub radiance: Vec3,
    /// d radiance / d parameter by plane; empty where no derivative is wanted.
    pub derivatives: &'a mut [Vec3],
}

impl Tally<'_> {
    /// Multiplies everything found so far.
    pub fn scale(&mut self, factor: f32) {
        self.radiance *= factor;
        self.derivatives.iter_mut().for_each(|sum| *sum *= factor);
    }

    /// Adds light that reaches the carrier with factor `weight`.
    #[inline]
    fn add(&mut self, carrier: &Carrier<'_>, weight: Vec3, emission: &Emission, plane: PlaneIndex) {
        let light = weight * emission.value;
        self.radiance += carrier.throughput * light;
        for (sum, derivative) in self.derivatives.iter_mut().zip(carrier.derivatives.iter()) {
            *sum += *derivative * light;
        }
        if let Some(plane) = plane
            && let Some(sum) = self.derivatives.get_mut(plane)
        {
            *sum += carrier.throughput * weight * emission.derivative;
        }
    }
}

/// Share of a strategy of density `own` beside one of density `other` (Veach 1997, power heuristic with exponent 2).
#[inline]
fn power(own: f32, other: f32) -> f32 {
    // Relative, so that the squares of a narrow lobe's densities do not overflow.
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}

/// Where a path is before one of its surfaces.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    /// The way to it.
    pub ray: Ray,
    /// What the ray hits first.
    pub hit: Option<Hit>,
    /// Surfaces before.
    pub bounce: u32,
    /// What light found from here on is worth.
    pub throughput: Vec3,
    /// What the throughput would be if the proposals reflected; decides about roulette alone.
    pub proposed: Vec3,
    /// Density of the direction that led here and the share of each light in the choice at the last surface; a camera
    /// ray competes with nothing.
    pub arrival: Option<(f32, f32)>,
    /// Groups of four numbers that the path has taken.
    pub groups: u32,
    /// Which of the paths from its camera ray's first surface it is.
    pub branch: u32,
}

impl Start {
    /// A camera ray.
    #[must_use]
    pub fn camera(ray: Ray, hit: Option<Hit>) -> Self {
        Self { ray, hit, bounce: 0, throughput: Vec3::ONE, proposed: Vec3::ONE, arrival: None, groups: 1, branch: 0 }
    }

    /// One of [`SPLIT`] paths that go on from what a camera ray hits.
    #[must_use]
    pub fn branch(ray: Ray, hit: Option<Hit>, branch: u32) -> Self {
        Self { throughput: Vec3::splat(SHARE), branch, ..Self::camera(ray, hit) }
    }

    /// Adds what a ray finds that ends at a light or in nothing, no derivative being carried along; whether it does.
    #[inline]
    pub fn arrives(&self, world: &World<'_>, tally: &mut Tally<'_>) -> bool {
        let carrier = Carrier { throughput: self.throughput, derivatives: &mut [] };
        arrives(world, &self.ray, self.hit, self.arrival, &carrier, tally)
    }
}

/// Whether a path's ray ends at a light, or in nothing: then what it finds there is added.
#[inline]
fn arrives(
    world: &World<'_>,
    ray: &Ray,
    hit: Option<Hit>,
    arrival: Option<(f32, f32)>,
    carrier: &Carrier<'_>,
    tally: &mut Tally<'_>,
) -> bool {
    let share = |pdf: f32| Vec3::splat(arrival.map_or(1.0, |(own, pick)| power(own, pdf * pick)));
    let limit = hit.map_or(f32::INFINITY, |h| h.t);
    if let Some((_, index)) = world.lights.sphere(ray.origin, ray.direction, limit) {
        if let Some((emission, pdf, plane)) = world.lights.sphere_emission(index, ray.origin, ray.direction) {
            tally.add(carrier, share(pdf), &emission, plane);
        }
        return true;
    }
    if hit.is_none() {
        for (emission, pdf, plane) in world.lights.environments(ray.direction) {
            tally.add(carrier, share(pdf), &emission, plane);
        }
    }
    hit.is_none()
}

/// The factor on what a sample towards a light brings: the chance that it was chosen, and its share where a path can come
/// upon the light as well, with density `other`.
#[inline(always)]
fn direct_weight(pdf: f32, pick: f32, other: Option<f32>) -> f32 {
    match other {
        _ if pdf <= 0.0 => 1.0 / pick,
        Some(other) => power(pdf * pick, other) / (pdf * pick),
        None => 1.0 / (pdf * pick),
    }
}

/// Traces a camera ray and the paths from its first surface; adds what they find to `tally`. `numbers` gives those of a path.
///
/// The other arguments are those of [`trace`].
pub fn trace_camera<'b, const SAME: bool>(
    world: &World<'_>,
    start: Start,
    numbers: impl Fn(u32) -> Sampler<'b>,
    scratch: &mut [Vec3],
    tally: &mut Tally<'_>,
) {
    if start.arrives(world, tally) {
        return;
    }
    for branch in 0..SPLIT {
        let before = std::mem::take(&mut tally.radiance);
        let mut numbers = numbers(branch);
        numbers.skip();
        trace::<SAME>(world, Start::branch(start.ray, start.hit, branch), &mut numbers, scratch, tally);
        tally.radiance = before + tally.radiance;
    }
}

/// Traces one path from `start`; adds what it finds to `tally`. `sampler` stands behind the numbers that the path
/// has taken.
///
/// `scratch` is workspace of as many vectors as there are planes (none without derivatives); its content does not matter.
///
/// `SAME` says that `world.proposals` are `world.shaders`.
pub fn trace<const SAME: bool>(
    world: &World<'_>,
    start: Start,
    sampler: &mut Sampler<'_>,
    scratch: &mut [Vec3],
    tally: &mut Tally<'_>,
) {
    scratch.fill(Vec3::ZERO);
    let Start { mut ray, mut hit, mut proposed, mut arrival, .. } = start;
    let mut carrier = Carrier { throughput: start.throughput, derivatives: scratch };
    // Lights of intensity 0 have no part in the radiance: their derivatives must not shift its numbers.
    let mut dark = (world.lights.dark() > 0 && !tally.derivatives.is_empty()).then(|| sampler.aside(Aside::Dark));
    let mut beneath = None;
    for bounce in start.bounce.. {
        if arrives(world, &ray, hit, arrival, &carrier, tally) {
            return;
        }
        let Some(h) = hit else { return };
        let mut surface = world.geometry.surface(&h);
        if bounce == 0 {
            surface.footprint = world.spread * h.t;
        }
        let shader = &world.shaders[world.shader_of[surface.part]];
        let proposal = if SAME { shader } else { &world.proposals[world.shader_of[surface.part]] };
        let local = shader.local(&surface, world.geometry);
        let wo = local.basis.local(-ray.direction);
        // The proposals' frame is their own: their normals may be others.
        let other;
        let (chooser, towards_chooser) = if SAME {
            (&local, wo)
        } else {
            other = proposal.local(&surface, world.geometry);
            (&other, other.basis.local(-ray.direction))
        };
        if towards_chooser.z <= 0.0 {
            return;
        }
        let differentiate = shader.freed && !carrier.derivatives.is_empty();
        let numbers = sampler.next4();
        let towards = sampler.next4();

        let lights = world.lights.sampled();
        let all = bounce == 0 && lights <= ALL_LIGHTS;
        let pick = if all || lights == 0 { 1.0 } else { 1.0 / lights as f32 };
        if below::is_translucent(shader, &surface) {
            // A guide that lets no light below knows no way there.
            let (guide, chooser, towards_eye) = if proposal.scatter_distance() > 0.0 {
                (proposal, chooser, towards_chooser)
            } else {
                (shader, &local, wo)
            };
            let here = below::Bounce {
                world,
                surface: &surface,
                shader,
                local: &local,
                wo,
                guide,
                chooser,
                towards: towards_eye,
                bounce,
            };
            let beneath = beneath.get_or_insert_with(|| sampler.aside(Aside::Below));
            let numbers = below::Numbers { lobe: numbers, lights: towards, probe: beneath.next4() };
            match here.follow(&numbers, sampler, &mut dark, &mut proposed, &mut carrier, tally) {
                Some((next, pdf)) => {
                    ray = next;
                    hit = world.geometry.closest(&ray);
                    arrival = Some((pdf, pick));
                    continue;
                }
                None => return,
            }
        }
        // `met` says that a path can come upon the light as well; `pick` is the chance that it was chosen.
        let mut direct = |light: Option<(LightSample, PlaneIndex)>, pick: f32, met: bool| {
            let Some((sample, plane)) = light else { return };
            let wi = local.basis.local(sample.direction);
            if wi.z <= 0.0 {
                return;
            }
            let mut slots = [Vec3::ZERO; MAX_SLOTS];
            let found = if differentiate {
                shader.evaluate_with_derivatives(&local, wo, wi, &mut slots)
            } else {
                shader.evaluate(&local, wo, wi)
            };
            if found.value == Vec3::ZERO && !differentiate {
                return;
            }
            let shadow = surface.ray_to(sample.direction, sample.distance);
            if world.geometry.occluded(&shadow) || world.lights.in_the_way(&shadow) {
                return;
            }
            let other = (sample.pdf > 0.0 && met).then(|| {
                if SAME {
                    found.pdf
                } else {
                    proposal.evaluate(chooser, towards_chooser, chooser.basis.local(sample.direction)).pdf
                }
            });
            let weight = direct_weight(sample.pdf, pick, other);
            tally.add(&carrier, found.value * weight, &sample.emission, plane);
            if differentiate {
                let factor = carrier.throughput * sample.emission.value * weight;
                shader.scatter(&local, wo, wi, &slots, factor, tally.derivatives);
            }
        };
        if all {
            // What is the same for all paths from a camera ray's first surface, the first one finds for all of them.
            for index in (0..lights).filter(|index| start.branch == 0 && world.lights.is_fixed(*index)) {
                direct(world.lights.sample(index, surface.position, Vec2::ZERO), SHARE, true);
            }
            // One pair of numbers each; beyond the two at hand, a fresh group.
            for index in 0..lights {
                let u = match index {
                    0 => Vec2::new(towards[0], towards[1]),
                    1 => Vec2::new(towards[2], towards[3]),
                    _ => {
                        let fresh = sampler.next4();
                        Vec2::new(fresh[0], fresh[1])
                    }
                };
                if !world.lights.is_fixed(index) {
                    direct(world.lights.sample(index, surface.position, u), pick, true);
                }
            }
        } else if lights > 0 {
            let index = ((towards[2] * lights as f32) as usize).min(lights - 1);
            let u = Vec2::new(towards[0], towards[1]);
            direct(world.lights.sample(index, surface.position, u), pick, true);
        }
        if let Some(dark) = &mut dark {
            let lights = world.lights.dark();
            let each = if bounce == 0 { lights.min(ALL_LIGHTS) } else { 1 };
            // All of them, or as many at random.
            for k in 0..each {
                let [u, v, w, _] = dark.next4();
                let index = if each == lights { k } else { ((w * lights as f32) as usize).min(lights - 1) };
                let light = world.lights.sample_dark(index, surface.position, Vec2::new(u, v));
                direct(light, each as f32 / lights as f32, false);
            }
        }

        let uniform = [numbers[0], numbers[1], numbers[2]];
        let Some(drawn) = proposal.sample_direction(chooser, towards_chooser, uniform) else { return };
        let leaving = chooser.basis.world(drawn);
        let wi = if SAME { drawn } else { local.basis.local(leaving) };
        let mut slots = [Vec3::ZERO; MAX_SLOTS];
        let found = if differentiate {
            shader.evaluate_with_derivatives(&local, wo, wi, &mut slots)
        } else {
            shader.evaluate(&local, wo, wi)
        };
        let chosen = if SAME { found } else { proposal.evaluate(chooser, towards_chooser, drawn) };
        if chosen.pdf <= 0.0 {
            return;
        }
        proposed *= chosen.value / chosen.pdf;
        let survival = survival(bounce, proposed);
        if numbers[3] >= survival {
            return;
        }
        proposed /= survival;
        let weight = 1.0 / (chosen.pdf * survival);
        for derivative in carrier.derivatives.iter_mut() {
            *derivative *= found.value * weight;
        }
        if differentiate {
            shader.scatter(&local, wo, wi, &slots, carrier.throughput * weight, carrier.derivatives);
        }
        carrier.throughput *= found.value * weight;
        if carrier.throughput == Vec3::ZERO && carrier.derivatives.iter().all(|d| *d == Vec3::ZERO) {
            return;
        }
        ray = surface.ray(leaving, f32::INFINITY);
        hit = world.geometry.closest(&ray);
        arrival = Some((chosen.pdf, pick));
    }
}
