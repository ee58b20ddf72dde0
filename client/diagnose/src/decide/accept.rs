//! The one rule of acceptance, for whatever is added to a model, kept in it, refined, and for photos and measured reflectance alike.
//!
//! An extension is accepted if it lowers the deviance of units that it was not fitted to
//!
//! 1. by what matters: a smallest gain of interest, relative to how wrong the base model is, and
//! 2. by no accident of few units: were the sign of each unit's gain arbitrary, a sum as large as the one that was found would come up with
//!    a chance of [`Policy::accident`] at most.
//!
//! The second is Fisher's randomisation test for pairs ("The Design of Experiments", 1935, section 21). It is exact for 5 units and
//! for 100, and asks nothing of the distribution but symmetry about zero where there is no gain. A standard error, which stood here
//! before, is known badly from five photos, and one photo of heavy tail makes it as large as the gain. With `n` units no chance is below 2^-n; where
//! that is more than the policy asks for, all units must gain.

use super::{BASE, noise_level};
use crate::evidence::{Evidence, FittedModel, Folds, ScorePass, UnitKind};
use crate::policy::Policy;

/// Units up to which all 2^n signs are counted; beyond, as many random ones stand for them.
const EXACT: usize = 12;
/// Odd constant of the additive generator of signs: 2^64 over the golden ratio (Steele, Lea and Flood 2014, "SplitMix").
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Chance that a sum of gains as large as theirs comes up if each had an arbitrary sign.
#[must_use]
pub fn accident(gains: &[f64]) -> f64 {
    let observed: f64 = gains.iter().sum();
    // A tie counts; rounding must not undo it.
    let least = observed - 1e-12 * gains.iter().map(|g| g.abs()).sum::<f64>();
    let trials = 1_u64 << gains.len().min(EXACT);
    let signs =
        |trial: u64| if gains.len() <= EXACT { trial } else { mixed(trial.wrapping_add(1).wrapping_mul(GOLDEN)) };
    let sum = |trial: u64| -> f64 {
        let bits = signs(trial);
        let each = gains.iter().enumerate().map(|(i, g)| {
            let word = if i < 64 { bits } else { mixed(bits ^ (i as u64 / 64)) };
            if word >> (i % 64) & 1 == 1 { -g } else { *g }
        });
        each.sum()
    };
    (0..trials).filter(|trial| sum(*trial) >= least).count() as f64 / trials as f64
}

/// The output function of SplitMix64.
fn mixed(seed: u64) -> u64 {
    let z = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Whether gains are believed at a chance of accident.
#[must_use]
pub fn believed(gains: &[f64], chance: f64) -> bool {
    // As many units as there are cannot do better than all of them.
    let possible = 0.5_f64.powi(i32::try_from(gains.len()).unwrap_or(i32::MAX));
    accident(gains) <= chance.max(possible)
}

/// Two models' deviances, unit by unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// By unit: decrease of its deviance when it is left out.
    gains: Vec<f64>,
    /// By unit: its deviance before, when it is left out.
    before: Vec<f64>,
    /// By unit: decrease of its deviance where it is fitted to.
    falls: Vec<f64>,
}

/// A model's deviances: as fitted, and left out.
#[derive(Debug, Clone, Copy)]
pub struct Deviances<'a> {
    /// By unit, as fitted.
    pub loss: &'a [f64],
    /// By unit, left out.
    pub left_out: &'a [f64],
}

impl<'a> Deviances<'a> {
    /// Of a model.
    #[must_use]
    pub fn of(model: &'a FittedModel) -> Self {
        Self { loss: &model.loss, left_out: folded(model).unwrap_or(&model.left_out) }
    }

    /// Of a model by its score pass.
    #[must_use]
    pub fn by(pass: &'a ScorePass, model: &'a FittedModel) -> Self {
        Self { loss: &pass.loss, left_out: folded(model).unwrap_or(&pass.left_out) }
    }
}

fn folded(model: &FittedModel) -> Option<&[f64]> {
    match &model.folds {
        Folds::Known(known) => Some(known),
        Folds::Untried | Folds::Impossible => None,
    }
}

impl Comparison {
    /// From one model to another.
    #[must_use]
    pub fn between(before: Deviances<'_>, after: Deviances<'_>) -> Self {
        let less = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        Self {
            gains: less(before.left_out, after.left_out),
            before: before.left_out.to_vec(),
            falls: less(before.loss, after.loss),
        }
    }

    /// Decrease of left-out deviance per observation of all units: at most what the fitted deviance falls by, since what is left
    /// out cannot gain more than what is fitted.
    #[must_use]
    pub fn gain(&self, evidence: &Evidence) -> f64 {
        (self.predicted(evidence)).min(self.fall(evidence))
    }

    /// The same without that bound.
    #[must_use]
    pub fn predicted(&self, evidence: &Evidence) -> f64 {
        self.gains.iter().sum::<f64>() / evidence.observations()
    }

    /// Standard error of the gain by the scatter between units.
    #[must_use]
    pub fn error(&self, evidence: &Evidence) -> f64 {
        let (n, sum) = (self.gains.len() as f64, self.gains.iter().sum::<f64>());
        let variance = self.gains.iter().map(|g| (g - sum / n).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        (n * variance).sqrt() / evidence.observations()
    }

    /// Decrease of the fitted deviance per observation.
    #[must_use]
    pub fn fall(&self, evidence: &Evidence) -> f64 {
        self.falls.iter().sum::<f64>() / evidence.observations()
    }

    /// By unit: how much more this one gains than another from the same model.
    #[must_use]
    pub fn beyond(&self, other: &Self) -> Vec<f64> {
        self.gains.iter().zip(&other.gains).map(|(own, other)| own - other).collect()
    }

    /// The rule, for what was added; `suspect` is the photo that all of its numbers belong to, if one alone is suspected: there, that no other
    /// photo gains is what was claimed, and no accident.
    ///
    /// Photos and files are judged each by their own measure; either is enough, so that neither the photos' many pixels drown
    /// the files, nor the files' unexplained structure speaks for effects of a camera.
    #[must_use]
    pub fn matters(&self, evidence: &Evidence, policy: &Policy, suspect: Option<usize>) -> bool {
        let of = |kind: UnitKind, values: &[f64]| -> Vec<f64> {
            evidence.units.iter().zip(values).filter(|(u, _)| u.kind == kind).map(|(_, v)| *v).collect()
        };
        let sum = |values: &[f64]| values.iter().sum::<f64>();
        let photos = of(UnitKind::Photo, &self.gains);
        let files = of(UnitKind::File, &self.gains);
        let fall = sum(&of(UnitKind::Photo, &self.falls));
        let enough_for_photos = !photos.is_empty()
            && sum(&photos).min(fall) >= least_of_photos(evidence, policy)
            && (suspect.is_some() || believed(&photos, policy.accident));
        let before = sum(&of(UnitKind::File, &self.before));
        let enough_for_files = !files.is_empty()
            && error_gain(before, before - sum(&files)) >= policy.smallest_file_gain
            && believed(&files, policy.accident);
        enough_for_photos || enough_for_files
    }
}

/// By which part the root of mean squares falls from one sum of squares to another.
#[must_use]
pub fn error_gain(before: f64, after: f64) -> f64 {
    if before > 0.0 { 1.0 - (after / before).max(0.0).sqrt() } else { 0.0 }
}

/// Least decrease of all photos' deviance that matters to them.
fn least_of_photos(evidence: &Evidence, policy: &Policy) -> f64 {
    let [observations, floor, loss] = sums(evidence, UnitKind::Photo);
    let noise = noise_level(evidence, policy);
    let above = if floor > 0.0 { loss / floor - noise } else { 0.0 };
    (policy.smallest_gain * above).max(policy.floor * noise) * observations
}

/// Least decrease of deviance per observation of all units that could matter to either kind.
#[must_use]
pub fn least(evidence: &Evidence, policy: &Policy) -> f64 {
    let [photos, _, _] = sums(evidence, UnitKind::Photo);
    let [files, _, of_files] = sums(evidence, UnitKind::File);
    let part = 1.0 - (1.0 - policy.smallest_file_gain).powi(2);
    let to_photos = if photos > 0.0 { least_of_photos(evidence, policy) } else { f64::INFINITY };
    let to_files = if files > 0.0 { part * of_files } else { f64::INFINITY };
    to_photos.min(to_files) / evidence.observations()
}

/// Observations, noise floor and base deviance of the units of a kind.
fn sums(evidence: &Evidence, kind: UnitKind) -> [f64; 3] {
    let loss = evidence.models.get(BASE).map(|m| m.loss.as_slice()).unwrap_or_default();
    let units = evidence.units.iter().zip(loss).filter(|(u, _)| u.kind == kind);
    units.fold([0.0; 3], |[n, floor, sum], (u, loss)| [n + u.observations, floor + u.floor, sum + loss])
}
