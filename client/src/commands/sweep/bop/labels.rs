//! Which frame becomes which image of the dataset.

use gonio_sweep::{Label, Plan};
use std::collections::{BTreeMap, BTreeSet};

/// A label for every frame. Where each view is rendered once and all repeat images of another dataset, they keep those
/// numbers, so that the two can be paired; where each is rendered once, there is one scene; else every point is a scene.
pub(super) fn labels(plan: &Plan) -> Vec<Label> {
    let repeated: Option<Vec<Label>> =
        plan.frames.iter().map(|frame| plan.labels.get(frame.photo).copied().flatten()).collect();
    if let Some(labels) = repeated
        && labels.iter().collect::<BTreeSet<_>>().len() == labels.len()
    {
        return labels;
    }
    let photos: BTreeSet<usize> = plan.frames.iter().map(|frame| frame.photo).collect();
    let once = photos.len() == plan.frames.len();
    let mut counts: BTreeMap<u32, u32> = BTreeMap::new();
    let number = |frame: &gonio_sweep::Frame| {
        // A sweep has at most a million points.
        let scene = if once { 1 } else { u32::try_from(frame.point).unwrap_or(u32::MAX - 1) + 1 };
        let next = counts.entry(scene).or_default();
        let image = *next;
        *next += 1;
        Label { scene, image }
    };
    plan.frames.iter().map(number).collect()
}
