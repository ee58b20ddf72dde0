//! A path's bounce at a translucent surface: what arrives is either reflected there, or enters elsewhere, scatters below
//! and leaves there.
//!
//! At a path's first surface every entry that the probes find is lit; later on one of them, at random. In both cases one of
//! them is where the path goes on if it goes below.

use super::probe::{self, Entry, MOST};
use super::roulette::survival;
use super::{ALL_LIGHTS, Carrier, Tally, World, power};
use crate::bvh::Ray;
use crate::geometry::Surface;
use crate::light::LightSample;
use crate::planes::PlaneIndex;
use crate::sampler::Sampler;
use crate::shader::{Local, Shader};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Mean free paths below so many times what a position may be off leave light where it enters.
const LEAST: f32 = 4.0;

/// A surface with its exit frame, and who chooses directions there.
pub struct Bounce<'a> {
    pub world: &'a World<'a>,
    pub surface: &'a Surface,
    pub shader: &'a Shader,
    pub local: &'a Local,
    /// Towards the eye, in the frame of `local`.
    pub wo: Vec3,
    /// Whose lobes and profile choose, its frame, and the way to the eye in that.
    pub guide: &'a Shader,
    pub chooser: &'a Local,
    pub towards: Vec3,
    /// Surfaces before.
    pub bounce: u32,
}

/// The numbers of a bounce: those that any surface takes, and the place of the probe.
pub struct Numbers {
    pub lobe: [f32; 4],
    pub lights: [f32; 4],
    pub probe: [f32; 4],
}

/// A way on: reflected, or through an entry.
struct Way {
    from: Surface,
    entry: Option<Through>,
    /// The chance that a path goes this way, given that the way is lit.
    chance: f32,
}

/// A way through an entry.
struct Through {
    local: Local,
    chooser: Local,
    r: f32,
    /// 1 / density per area, over the chance that the entry is lit.
    weight: f32,
}

/// Whether light leaves such a surface elsewhere than where it enters.
#[inline]
pub fn is_translucent(shader: &Shader, surface: &Surface) -> bool {
    let distance = shader.scatter_distance();
    distance > 0.0 && distance > LEAST * surface.margin
}

impl Bounce<'_> {
    /// Lights the surface and goes on: the next ray and the density of its direction. None where the path ends.
    pub fn follow(
        &self,
        numbers: &Numbers,
        sampler: &mut Sampler<'_>,
        dark: &mut Option<Sampler<'_>>,
        proposed: &mut Vec3,
        carrier: &mut Carrier<'_>,
        tally: &mut Tally<'_>,
    ) -> Option<(Ray, f32)> {
        let chance_below = self.guide.chance_below(self.chooser, self.towards);
        let (mut ways, picked) = self.entries(numbers.probe, chance_below)?;
        let above = Way { from: *self.surface, entry: None, chance: 1.0 };
        let all_ways = || std::iter::once(&above).chain(ways.iter().flatten());
        let lights = self.world.lights.sampled();
        let all = self.bounce == 0 && lights <= ALL_LIGHTS;
        let [u, v, w, z] = numbers.lights;
        if all {
            for index in 0..lights {
                let u = match index {
                    0 => Vec2::new(u, v),
                    1 => Vec2::new(w, z),
                    _ => {
                        let fresh = sampler.next4();
                        Vec2::new(fresh[0], fresh[1])
                    }
                };
                for way in all_ways() {
                    self.light(way, self.world.lights.sample(index, way.from.position, u), 1.0, true, carrier, tally);
                }
            }
        } else if lights > 0 {
            let index = ((w * lights as f32) as usize).min(lights - 1);
            let pick = 1.0 / lights as f32;
            for way in all_ways() {
                let light = self.world.lights.sample(index, way.from.position, Vec2::new(u, v));
                self.light(way, light, pick, true, carrier, tally);
            }
        }
        if let Some(dark) = dark {
            let lights = self.world.lights.dark();
            let each = if self.bounce == 0 { lights.min(ALL_LIGHTS) } else { 1 };
            for k in 0..each {
                let [u, v, w, _] = dark.next4();
                let index = if each == lights { k } else { ((w * lights as f32) as usize).min(lights - 1) };
                for way in all_ways() {
                    let light = self.world.lights.sample_dark(index, way.from.position, Vec2::new(u, v));
                    self.light(way, light, each as f32 / lights as f32, false, carrier, tally);
                }
            }
        }

        let [choice, u, v, roulette] = numbers.lobe;
        let (way, leaving) = if self.guide.goes_below(self.chooser, self.towards, choice) {
            let way = ways.get_mut(picked?)?.take()?;
            let through = way.entry.as_ref()?;
            let (sin, cos) = libm::sincosf(TAU * v);
            let wi = Vec3::new(u.sqrt() * cos, u.sqrt() * sin, (1.0 - u).sqrt());
            let leaving = through.chooser.basis.world(wi);
            (way, leaving)
        } else {
            let drawn = self.guide.sample_direction(self.chooser, self.towards, [choice, u, v])?;
            (above, self.chooser.basis.world(drawn))
        };
        let pdf = self.pdf(&way, leaving);
        if pdf <= 0.0 {
            return None;
        }
        *proposed *= self.guide_value(&way, leaving) / pdf;
        let survival = survival(self.bounce, *proposed);
        if roulette >= survival {
            return None;
        }
        *proposed /= survival;
        let weight = 1.0 / (pdf * survival);
        let value = self.value(&way, leaving) * weight;
        carrier.derivatives.iter_mut().for_each(|derivative| *derivative *= value);
        if self.shader.freed && !carrier.derivatives.is_empty() {
            self.scatter(&way, leaving, carrier.throughput * weight, carrier.derivatives);
        }
        carrier.throughput *= value;
        let alive = carrier.throughput != Vec3::ZERO || carrier.derivatives.iter().any(|d| *d != Vec3::ZERO);
        alive.then(|| (way.from.ray(leaving, f32::INFINITY), pdf))
    }

    /// The ways through entries, and which of them a path that goes below takes.
    fn entries(&self, [u, v, choice, _]: [f32; 4], chance_below: f32) -> Option<([Option<Way>; MOST], Option<usize>)> {
        let profile = self.guide.profile(self.chooser, self.shader.scatter_distance())?;
        let found = probe::entries(self.world.geometry, self.surface, &self.chooser.basis, &profile, [u, v]);
        let share = |entry: &Entry| profile.value(entry.r).max_element() * entry.weight;
        let total: f32 = found.iter().flatten().map(share).sum();
        let (mut left, mut picked) = (choice * total, None);
        for (index, entry) in found.iter().enumerate() {
            let Some(entry) = entry else { break };
            picked = Some(index);
            left -= share(entry);
            if left < 0.0 {
                break;
            }
        }
        let every = self.bounce == 0;
        let mut ways = [const { None }; MOST];
        for (index, entry) in found.iter().enumerate() {
            let Some(entry) = entry else { break };
            if !every && picked != Some(index) {
                continue;
            }
            let part = share(entry) / total;
            let local = self.shader.entry(&entry.surface, self.world.geometry, &self.local.basis);
            let chooser = if std::ptr::eq(self.shader, self.guide) {
                local
            } else {
                self.guide.entry(&entry.surface, self.world.geometry, &self.chooser.basis)
            };
            let (weight, chance) =
                if every { (entry.weight, chance_below * part) } else { (entry.weight / part, chance_below) };
            let through = Through { local, chooser, r: entry.r, weight };
            ways[index] = Some(Way { from: entry.surface, entry: Some(through), chance });
        }
        Some((ways, picked))
    }

    /// Adds what a light sends along a way. `met` says that a path can come upon the light as well; `pick` is the chance that
    /// it was chosen.
    fn light(
        &self,
        way: &Way,
        light: Option<(LightSample, PlaneIndex)>,
        pick: f32,
        met: bool,
        carrier: &Carrier<'_>,
        tally: &mut Tally<'_>,
    ) {
        let Some((sample, plane)) = light else { return };
        let differentiate = self.shader.freed && !carrier.derivatives.is_empty();
        let value = self.value(way, sample.direction);
        if value == Vec3::ZERO && !differentiate {
            return;
        }
        let shadow = way.from.ray_to(sample.direction, sample.distance);
        let blocked = self.world.geometry.occluded(&shadow) || self.world.lights.in_the_way(&shadow);
        if blocked {
            return;
        }
        let own = if sample.pdf > 0.0 { sample.pdf * pick } else { pick };
        let weight =
            if sample.pdf > 0.0 && met { power(own, self.pdf(way, sample.direction)) / own } else { 1.0 / own };
        tally.add(carrier, value * weight, &sample.emission, plane);
        if differentiate {
            let factor = carrier.throughput * sample.emission.value * weight;
            self.scatter(way, sample.direction, factor, tally.derivatives);
        }
    }

    /// What a way makes of light from a direction.
    fn value(&self, way: &Way, from: Vec3) -> Vec3 {
        Self::worth(self.shader, self.local, self.wo, way, way.entry.as_ref().map(|t| &t.local), from)
    }

    /// The same if the guide reflected.
    fn guide_value(&self, way: &Way, from: Vec3) -> Vec3 {
        Self::worth(self.guide, self.chooser, self.towards, way, way.entry.as_ref().map(|t| &t.chooser), from)
    }

    fn worth(shader: &Shader, exit: &Local, wo: Vec3, way: &Way, entry: Option<&Local>, from: Vec3) -> Vec3 {
        match (&way.entry, entry) {
            (Some(through), Some(entry)) => {
                shader.below([exit, entry], wo, entry.basis.local(from), through.r) * through.weight
            }
            _ => shader.evaluate_above(exit, wo, exit.basis.local(from)).value,
        }
    }

    /// The density with which a path goes on along a way to a direction.
    fn pdf(&self, way: &Way, to: Vec3) -> f32 {
        match &way.entry {
            None => self.guide.evaluate_above(self.chooser, self.towards, self.chooser.basis.local(to)).pdf,
            Some(through) => way.chance * through.chooser.basis.z.dot(to).max(0.0) * FRAC_1_PI,
        }
    }

    /// As [`Shader::scatter`], of a way.
    fn scatter(&self, way: &Way, from: Vec3, weight: Vec3, into: &mut [Vec3]) {
        match &way.entry {
            None => self.shader.scatter_above(self.local, self.wo, self.local.basis.local(from), weight, into),
            Some(Through { local, r, weight: each, .. }) => {
                let ways = [self.wo, local.basis.local(from)];
                self.shader.scatter_below([self.local, local], ways, *r, weight * *each, into);
            }
        }
    }
}
