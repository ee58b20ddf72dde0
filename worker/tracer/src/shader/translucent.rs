//! What the integrator asks of a translucent material: see `bsdf::layered::below`.

use super::{Local, Shader};
use crate::basis::Basis;
use crate::bsdf::{Evaluation, Profile};
use crate::geometry::{Geometry, Surface};
use crate::shader::effects::{Detail, Effects};
use glam::Vec3;

impl Shader {
    /// Mean free path below, metres; 0 where light leaves where it enters.
    #[inline]
    pub fn scatter_distance(&self) -> f32 {
        self.effects.as_ref().map_or(0.0, |effects| effects.scatter_distance())
    }

    /// The effects and a point's details.
    fn known<'a>(&'a self, local: &'a Local) -> Option<(&'a Effects, &'a Detail)> {
        Some((self.effects.as_deref()?, local.detail.as_ref()?))
    }

    /// As [`Shader::local`], for a point where light enters that leaves in the frame `exit`: its frame is that one, turned
    /// the shortest way.
    pub fn entry(&self, surface: &Surface, geometry: &Geometry, exit: &Basis) -> Local {
        let mut local = self.local(surface, geometry);
        let basis = exit.turned(local.basis.z);
        if let Some(detail) = &mut local.detail {
            detail.turn(&local.basis, &basis);
        }
        Local { basis, ..local }
    }

    /// The profile of light that leaves at a point, for a mean free path.
    pub fn profile(&self, local: &Local, distance: f32) -> Option<Profile> {
        self.known(local).map(|(effects, detail)| effects.profile(detail, distance))
    }

    /// As [`Shader::evaluate`], without the light from below; the density is that of paths that stay above.
    pub fn evaluate_above(&self, local: &Local, wo: Vec3, wi: Vec3) -> Evaluation {
        self.known(local).map_or(Evaluation::default(), |(effects, detail)| effects.evaluate_above(detail, wo, wi))
    }

    /// Whether a path goes below, by the number that chooses a lobe in [`Shader::sample_direction`].
    pub fn goes_below(&self, local: &Local, wo: Vec3, choice: f32) -> bool {
        self.known(local).is_some_and(|(effects, detail)| effects.goes_below(detail, wo, choice))
    }

    /// The chance of that.
    pub fn chance_below(&self, local: &Local, wo: Vec3) -> f32 {
        self.known(local).map_or(0.0, |(effects, detail)| effects.chance_below(detail, wo))
    }

    /// Light from `wi` at the entry that leaves towards `wo` at the exit, `r` away: per steradian and area.
    pub fn below(&self, [exit, entry]: [&Local; 2], wo: Vec3, wi: Vec3, r: f32) -> Vec3 {
        match (self.known(exit), &entry.detail) {
            (Some((effects, detail)), Some(entry)) => effects.below([detail, entry], wo, wi, r),
            _ => Vec3::ZERO,
        }
    }

    /// As [`Shader::scatter`], of [`Shader::evaluate_above`].
    pub fn scatter_above(&self, local: &Local, wo: Vec3, wi: Vec3, weight: Vec3, into: &mut [Vec3]) {
        if let Some((effects, detail)) = self.known(local) {
            effects.scatter::<false>(detail, wo, wi, weight, into);
        }
    }

    /// As [`Shader::scatter`], of [`Shader::below`].
    pub fn scatter_below(&self, at: [&Local; 2], ways: [Vec3; 2], r: f32, weight: Vec3, into: &mut [Vec3]) {
        if let (Some((effects, exit)), Some(entry)) = (self.known(at[0]), &at[1].detail) {
            effects.scatter_below([exit, entry], ways, r, weight, into);
        }
    }
}
