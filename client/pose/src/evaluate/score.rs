//! Recalls of BOP19: each measure at ten thresholds, and their mean.

use super::group::{Errors, Group};
use crate::errors::TAUS;
use serde::Serialize;

/// Thresholds of the benchmark's measures: parts of the diameter (MSSD) or of the visible surface (VSD), and with
/// [`PIXELS`] in pixels (MSPD).
pub const STEPS: [f64; 10] = TAUS;

/// Pixels, in an image 640 wide, of a threshold of 1: 0.05 is 5 pixels.
const PIXELS: f64 = 100.0;

/// What an error is measured by, in units of its threshold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Visible Surface Discrepancy with the tolerance of this index into [`TAUS`].
    Vsd(usize),
    /// Maximum symmetry-aware surface distance, in diameters.
    Mssd,
    /// Maximum symmetry-aware projection distance, in hundreds of pixels of an image 640 wide.
    Mspd,
    /// ADD, or ADD-S of an object with symmetries, in diameters.
    AddOrAddS,
    /// Mean projection distance, in pixels of the image.
    Projection,
    /// The larger of the angle over 5 degrees and the distance over 5 cm.
    Degrees5Centimetres5,
}

impl Measure {
    /// The error; infinite where it could not be computed.
    #[must_use]
    pub fn of(self, e: &Errors) -> f64 {
        match self {
            Self::Vsd(tau) => e.vsd.and_then(|vsd| vsd.get(tau).copied()).unwrap_or(f64::INFINITY),
            Self::Mssd => e.mssd / e.diameter,
            Self::Mspd => e.mspd * 640.0 / f64::from(e.width) / PIXELS,
            Self::AddOrAddS => (if e.symmetric { e.add_s } else { e.add }) / e.diameter,
            Self::Projection => e.projection,
            Self::Degrees5Centimetres5 => (e.rotation / 5.0).max(e.translation / 0.05),
        }
    }
}

/// A recall at a threshold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Recall {
    /// In the measure's units.
    pub threshold: f64,
    /// Part of the targets that were found, 0 to 1.
    pub recall: f64,
}

/// The recalls over some targets.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// How many objects were to be found.
    pub targets: usize,
    /// Mean of VSD, MSSD and MSPD; `None` without depth.
    pub average_recall: Option<f64>,
    /// Mean over ten tolerances and ten thresholds; `None` without depth.
    pub vsd: Option<f64>,
    /// Mean over ten thresholds from 0.05 to 0.5 of the diameter.
    pub mssd: f64,
    /// Mean over ten thresholds from 5 to 50 pixels in an image 640 wide.
    pub mspd: f64,
    /// At 0.1 of the diameter: ADD, or ADD-S where the model states symmetries.
    pub add_or_add_s: f64,
    /// At 5 pixels.
    pub projection: f64,
    /// At 5 degrees and 5 cm.
    pub degrees_5_cm_5: f64,
    /// MSSD at each threshold.
    pub mssd_recalls: Vec<Recall>,
    /// MSPD at each threshold, in hundreds of pixels.
    pub mspd_recalls: Vec<Recall>,
    /// VSD at each threshold, averaged over the tolerances; empty without depth.
    pub vsd_recalls: Vec<Recall>,
}

impl Scores {
    /// The recalls over `groups`; with VSD where `deep`.
    #[must_use]
    pub fn new(groups: &[&Group], deep: bool) -> Self {
        let curve = |measures: &[Measure]| -> Vec<Recall> {
            let at = |&threshold: &f64| mean(measures.iter().map(|&measure| recall(groups, measure, threshold)));
            STEPS.iter().map(|threshold| Recall { threshold: *threshold, recall: at(threshold) }).collect()
        };
        let (mssd_recalls, mspd_recalls) = (curve(&[Measure::Mssd]), curve(&[Measure::Mspd]));
        let tolerances: Vec<Measure> = (0..TAUS.len()).map(Measure::Vsd).collect();
        let vsd_recalls = if deep { curve(&tolerances) } else { Vec::new() };
        let whole = |curve: &[Recall]| mean(curve.iter().map(|point| point.recall));
        let (mssd, mspd) = (whole(&mssd_recalls), whole(&mspd_recalls));
        let vsd = deep.then(|| whole(&vsd_recalls));
        Self {
            targets: groups.iter().map(|group| group.targets()).sum(),
            average_recall: vsd.map(|vsd| (vsd + mssd + mspd) / 3.0),
            vsd,
            mssd,
            mspd,
            add_or_add_s: recall(groups, Measure::AddOrAddS, 0.1),
            projection: recall(groups, Measure::Projection, 5.0),
            degrees_5_cm_5: recall(groups, Measure::Degrees5Centimetres5, 1.0),
            mssd_recalls,
            mspd_recalls,
            vsd_recalls,
        }
    }
}

/// Part of the targets of `groups` that are found with an error below `threshold`; 0 where there is none.
#[must_use]
pub(super) fn recall(groups: &[&Group], measure: Measure, threshold: f64) -> f64 {
    let found = |group: &&Group| group.matches(threshold, |errors| measure.of(errors)).iter().flatten().count();
    let (found, targets) =
        (groups.iter().map(found).sum::<usize>(), groups.iter().map(|group| group.targets()).sum::<usize>());
    #[allow(clippy::cast_precision_loss)]
    if targets == 0 { 0.0 } else { found as f64 / targets as f64 }
}

/// 0 of nothing.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count == 0.0 { 0.0 } else { sum / count }
}
