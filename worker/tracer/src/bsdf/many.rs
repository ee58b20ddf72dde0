//! Reflectances of a block of paths that meet one material: the bits of single ones, in loops that vectorise.

// Several arrays at one index read better than nested zips.
#![allow(clippy::needless_range_loop)]

use super::{Bsdf, Evaluation};
use crate::vectors::{BLOCK, Lanes, Vectors};

/// [`Evaluation`]s side by side; at or below the horizon they mean nothing.
#[derive(Clone, Copy, Debug)]
pub struct Evaluations {
    /// BSDF times the cosine of `wi`, per steradian.
    pub value: Vectors,
    /// Density per steradian.
    pub pdf: Lanes,
}

impl Evaluations {
    /// All zero.
    pub const ZERO: Self = Self { value: Vectors::ZERO, pdf: [0.0; BLOCK] };

    #[inline(always)]
    fn set(&mut self, lane: usize, found: Evaluation) {
        self.value.set(lane, found.value);
        self.pdf[lane] = found.pdf;
    }
}

impl Bsdf {
    /// Whether there are loops for this model.
    pub fn has_many(&self) -> bool {
        matches!(self, Self::Lambert(_) | Self::Plastic(_))
    }

    /// What the loops need to know of directions, by their cosines: a plastic's transmittances.
    #[inline(always)]
    pub fn through(&self, directions: &Vectors, into: &mut Lanes) {
        if let Self::Plastic(model) = self {
            for (lane, through) in into.iter_mut().enumerate() {
                *through = model.through(directions.get(lane).z);
            }
        }
    }

    /// [`Bsdf::evaluate`] above the horizon.
    #[inline(always)]
    pub fn evaluate_many(&self, wo: &Vectors, wi: &Vectors, [o, i]: [&Lanes; 2], into: &mut Evaluations) {
        match self {
            Self::Lambert(model) => {
                for lane in 0..BLOCK {
                    into.set(lane, model.evaluate(wi.get(lane)));
                }
            }
            Self::Plastic(model) => {
                for lane in 0..BLOCK {
                    into.set(lane, model.evaluate_through(wo.get(lane), wi.get(lane), o[lane], i[lane]));
                }
            }
            Self::Conductor(_) => {}
        }
    }

    /// [`Bsdf::sample_direction`], with no regard to the horizon. `numbers` are those of `u`.
    #[inline(always)]
    pub fn sample_many(&self, wo: &Vectors, numbers: &[Lanes; 4], through: &Lanes, into: &mut Vectors) {
        let u = |lane: usize| [numbers[0][lane], numbers[1][lane], numbers[2][lane]];
        match self {
            Self::Lambert(model) => {
                for lane in 0..BLOCK {
                    into.set(lane, model.sample_direction(u(lane)));
                }
            }
            Self::Plastic(model) => {
                for lane in 0..BLOCK {
                    into.set(lane, model.sample_through(wo.get(lane), u(lane), through[lane]));
                }
            }
            Self::Conductor(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::bsdf::{Lambert, Plastic};
    use glam::Vec3;

    #[test]
    fn loops_give_the_bits_of_single_calls() {
        let color = Vec3::new(0.2, 0.5, 0.9);
        let all = [
            Bsdf::Lambert(Lambert::new(color).unwrap()),
            Bsdf::Plastic(Plastic::new(color, 0.4, 1.5, false).unwrap()),
            Bsdf::Plastic(Plastic::new(color, 0.05, 1.3, true).unwrap()),
        ];
        let number = |k: usize| (k as f32 * 0.618_034).fract();
        for bsdf in all {
            let mut mirrored = 0;
            for round in 0..200 {
                let mut wo = Vectors::ZERO;
                let mut numbers = [[0.0; BLOCK]; 4];
                for lane in 0..BLOCK {
                    let k = (round * BLOCK + lane) * 5;
                    let z = 0.01 + 0.99 * number(k);
                    let (s, c) = libm::sincosf(7.0 * number(k + 1));
                    wo.set(lane, Vec3::new(s, c, 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z);
                    (0..3).for_each(|d| numbers[d][lane] = number(k + 2 + d));
                }
                let (mut through, mut through_i) = ([0.0; BLOCK], [0.0; BLOCK]);
                let (mut wi, mut found) = (Vectors::ZERO, Evaluations::ZERO);
                bsdf.through(&wo, &mut through);
                bsdf.sample_many(&wo, &numbers, &through, &mut wi);
                bsdf.through(&wi, &mut through_i);
                bsdf.evaluate_many(&wo, &wi, [&through, &through_i], &mut found);
                for lane in 0..BLOCK {
                    let u = [numbers[0][lane], numbers[1][lane], numbers[2][lane]];
                    let drawn = bsdf.sample_direction(wo.get(lane), u);
                    assert_eq!(drawn, (wi.get(lane).z > 0.0).then_some(wi.get(lane)));
                    if let Some(wi) = drawn {
                        let single = bsdf.evaluate(wo.get(lane), wi);
                        assert_eq!((single.value, single.pdf), (found.value.get(lane), found.pdf[lane]));
                        mirrored += 1;
                    }
                }
            }
            assert!(mirrored > 1000);
        }
    }
}
