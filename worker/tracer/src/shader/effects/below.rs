//! Light that enters a translucent material at one place and leaves it at another, and its derivatives.

use super::{Detail, Effects, STEP};
use crate::bsdf::{Evaluation, Profile, Site};
use glam::{Vec2, Vec3};

impl Effects {
    /// Mean free path below, metres; 0 where light leaves where it enters.
    #[inline]
    pub fn scatter_distance(&self) -> f32 {
        if self.active { self.surface.scatter_distance() } else { 0.0 }
    }

    /// As `Layered::profile`.
    pub fn profile(&self, detail: &Detail, distance: f32) -> Profile {
        self.surface.profile(&detail.site, distance)
    }

    /// As `Layered::evaluate_above`.
    pub fn evaluate_above(&self, detail: &Detail, wo: Vec3, wi: Vec3) -> Evaluation {
        self.surface.evaluate_above(&detail.site, wo, wi)
    }

    /// As `Layered::goes_below`.
    pub fn goes_below(&self, detail: &Detail, wo: Vec3, choice: f32) -> bool {
        self.surface.goes_below(&detail.site, wo, choice)
    }

    /// As `Layered::chance_below`.
    pub fn chance_below(&self, detail: &Detail, wo: Vec3) -> f32 {
        self.surface.chance_below(&detail.site, wo)
    }

    /// As `Layered::below`, from the entry to the exit.
    pub fn below(&self, [exit, entry]: [&Detail; 2], wo: Vec3, wi: Vec3, r: f32) -> Vec3 {
        self.surface.below([&exit.site, &entry.site], wo, wi, r)
    }

    /// As [`Effects::scatter`], of [`Effects::below`]: numbers of a place act at the exit and at the entry.
    pub fn scatter_below(
        &self,
        [exit, entry]: [&Detail; 2],
        [wo, wi]: [Vec3; 2],
        r: f32,
        weight: Vec3,
        into: &mut [Vec3],
    ) {
        let sites = [&exit.site, &entry.site];
        let center = if self.needs_center { self.surface.below(sites, wo, wi, r) } else { Vec3::ZERO };
        for column in &self.columns {
            into[column.plane] += weight * column.derivative(center, |surface| surface.below(sites, wo, wi, r));
        }
        let slope = 0.5 / STEP * weight;
        // The derivative by the logarithm of a number of one place.
        let by = |moved: &dyn Fn(f32) -> [Site; 2]| {
            let at = |factor: f32| {
                let [exit, entry] = moved(factor);
                self.surface.below([&exit, &entry], wo, wi, r)
            };
            slope * (at(1.0 + STEP) - at(1.0 - STEP))
        };
        let [at_exit, at_entry] = [self.values(exit), self.values(entry)];
        if self.albedo.planes.is_some() {
            let derivative = by(&|f| [Site { albedo: exit.site.albedo * f, ..exit.site }, entry.site]);
            self.albedo.scatter(into, |k| derivative * at_exit[k]);
        }
        if self.roughness.planes.is_some() {
            let out = by(&|f| [Site { roughness: exit.site.roughness * f, ..exit.site }, entry.site]);
            let back = by(&|f| [exit.site, Site { roughness: entry.site.roughness * f, ..entry.site }]);
            self.roughness.scatter(into, |k| out * at_exit[k] + back * at_entry[k]);
        }
        if self.bump.planes.is_some() {
            let slope = 0.5 / self.tilt * weight;
            let turned = |v: Vec3, tilt: Vec2| {
                let scale = 1.0 / (1.0 + tilt.length_squared()).sqrt();
                (v.truncate() - tilt * v.z).extend(v.z + tilt.dot(v.truncate())) * scale
            };
            let tilted = |out: Vec2, back: Vec2| self.surface.below(sites, turned(wo, out), turned(wi, back), r);
            let axes = [Vec2::X * self.tilt, Vec2::Y * self.tilt];
            let out = axes.map(|t| slope * (tilted(t, Vec2::ZERO) - tilted(-t, Vec2::ZERO)));
            let back = axes.map(|t| slope * (tilted(Vec2::ZERO, t) - tilted(Vec2::ZERO, -t)));
            let [at_exit, at_entry] = [exit.tilts(), entry.tilts()];
            self.bump.scatter(into, |k| {
                let sum = |by: &[Vec3; 2], tilt: Vec2| by[0] * tilt.x + by[1] * tilt.y;
                sum(&out, at_exit[k]) + sum(&back, at_entry[k])
            });
        }
    }
}
