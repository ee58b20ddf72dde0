//! The 6D detection of BOP24: average precision of MSSD and of MSPD.

use super::LEAST_VISIBLE;
use super::group::Group;
use super::score::{Measure, STEPS, mean};
use serde::Serialize;
use std::collections::BTreeMap;

/// Average precisions, 0 to 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detection {
    /// Mean of MSSD and MSPD.
    pub average_precision: f64,
    /// Mean over objects and ten thresholds.
    pub mssd: f64,
    /// Mean over objects and ten thresholds.
    pub mspd: f64,
    /// MSSD and MSPD of each object, means over the thresholds; objects that are nowhere visible are not among them.
    pub objects: BTreeMap<u32, [f64; 2]>,
}

impl Detection {
    /// Of the groups of each object.
    pub(super) fn new(objects: &BTreeMap<u32, Vec<&Group>>) -> Self {
        let over = |groups: &[&Group], measure| -> Option<f64> {
            let each: Option<Vec<f64>> = STEPS.iter().map(|&step| at(groups, measure, step)).collect();
            each.map(|each| mean(each.into_iter()))
        };
        let both = |groups: &[&Group]| Some([over(groups, Measure::Mssd)?, over(groups, Measure::Mspd)?]);
        let objects: BTreeMap<u32, [f64; 2]> =
            objects.iter().filter_map(|(&object, groups)| Some((object, both(groups)?))).collect();
        let mssd = mean(objects.values().map(|[mssd, _]| *mssd));
        let mspd = mean(objects.values().map(|[_, mspd]| *mspd));
        Self { average_precision: (mssd + mspd) / 2.0, mssd, mspd, objects }
    }
}

/// Of one object at one threshold; `None` where it is nowhere to be found.
fn at(groups: &[&Group], measure: Measure, threshold: f64) -> Option<f64> {
    let mut detections = Vec::new();
    let mut targets = 0;
    for group in groups {
        let seen = |truth: usize| group.visible.get(truth).is_some_and(|&visible| visible >= LEAST_VISIBLE);
        targets += (0..group.visible.len()).filter(|&truth| seen(truth)).count();
        let found = group.matches(threshold, |errors| measure.of(errors));
        for (estimate, &score) in group.scores.iter().enumerate() {
            match found.iter().position(|&by| by == Some(estimate)) {
                // Neither right nor wrong: hardly visible.
                Some(truth) if !seen(truth) => {}
                hit => detections.push((score, hit.is_some())),
            }
        }
    }
    (targets > 0).then(|| average_precision(&mut detections, targets))
}

/// Average precision, as COCO interpolates it at 101 recalls, of detections as (score, right or not) where `targets` were
/// to be found.
pub fn average_precision(detections: &mut [(f64, bool)], targets: usize) -> f64 {
    detections.sort_by(|a, b| b.0.total_cmp(&a.0));
    #[allow(clippy::cast_precision_loss)]
    let part = |some: usize, all: usize| some as f64 / all as f64;
    let mut hits = 0;
    let mut curve = Vec::with_capacity(detections.len());
    for (index, (_, right)) in detections.iter().enumerate() {
        hits += usize::from(*right);
        curve.push((part(hits, targets), part(hits, index + 1)));
    }
    // The best precision at this recall or a higher one.
    for index in (1..curve.len()).rev() {
        let next = curve.get(index).map_or(0.0, |point| point.1);
        if let Some(point) = curve.get_mut(index - 1) {
            point.1 = point.1.max(next);
        }
    }
    let precision = |step: u32| {
        let recall = if step == 100 { 1.0 } else { f64::from(step) * 0.01 };
        curve.iter().find(|point| point.0 >= recall).map_or(0.0, |point| point.1)
    };
    mean((0..=100).map(precision))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn average_precision_of_known_lists() {
        assert_eq!(average_precision(&mut [(0.9, true), (0.8, true)], 2), 1.0);
        assert_eq!(average_precision(&mut [], 2), 0.0);
        assert_eq!(average_precision(&mut [(0.9, false)], 2), 0.0);
        // Half of the recalls (0 to 0.5: 51 of 101) are reached, with precision 1.
        assert!((average_precision(&mut [(0.9, true)], 2) - 51.0 / 101.0).abs() < 1e-12);
        // Wrong before right: precision 1/2 at both recalls up to 0.5, then 2/3 at all: the envelope is 2/3.
        let mut list = [(0.7, true), (0.9, false), (0.8, true)];
        assert!((average_precision(&mut list, 2) - 2.0 / 3.0).abs() < 1e-12);
    }
}
