//! What recall, and in BOP24 what precision, a list of estimates reaches on a dataset.

mod detection;
mod group;
mod overlay;
mod plot;
mod score;
mod table;

pub use detection::{Detection, average_precision};
pub use group::{Errors, Group, Pair};
pub use overlay::overlay;
pub use plot::plot;
pub use score::{Measure, Recall, STEPS, Scores};
pub use table::{errors_table, images_table, recalls_table};

use crate::bop::{Dataset, Estimate, Model, Models, Target};
use crate::errors::Shape;
use gonio_scene::{Result, SceneError};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Objects less visible than this are no targets of the benchmark.
pub const LEAST_VISIBLE: f64 = 0.1;

/// The most estimates of an image that BOP24 looks at, surest first.
const MOST_DETECTIONS: usize = 100;

/// The outcome.
#[derive(Debug, Serialize)]
pub struct Evaluation {
    /// Recalls of the 6D localisation of BOP19 over all targets; `None` with targets of BOP24.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scores: Option<Scores>,
    /// The same per object.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub objects: BTreeMap<u32, Scores>,
    /// Average precision of the 6D detection of BOP24; `None` with targets of BOP19.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detection: Option<Detection>,
    /// Mean seconds per image, over the images whose estimates state it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds_per_image: Option<f64>,
    /// Estimates that no target asks for, and which count for nothing.
    pub estimates_without_target: usize,
    /// What was left out, and why.
    pub notes: Vec<String>,
    /// Every object in every image with the estimates that were held against it.
    #[serde(skip)]
    pub groups: Vec<Group>,
}

/// The targets of a dataset that lists none: every object of every image that is visible by a tenth or more.
#[must_use]
pub fn default_targets(dataset: &Dataset) -> Vec<Target> {
    let mut targets = Vec::new();
    for (scene, image, frame) in dataset.frames() {
        let mut counts = BTreeMap::new();
        for truth in frame.truths.iter().filter(|truth| truth.visible.unwrap_or(1.0) >= LEAST_VISIBLE) {
            *counts.entry(truth.object).or_insert(0) += 1;
        }
        let target = |(object, count)| Target { scene, image, object: Some(object), count: Some(count) };
        targets.extend(counts.into_iter().map(target));
    }
    targets
}

/// Holds `estimates` against the poses of `dataset`, as the benchmark does: BOP19 where `targets` name objects, BOP24
/// where they name images alone. VSD is left out, and a note says so, where an image with a target has no depth.
///
/// # Errors
/// A target in an image that the dataset does not have, an object without a model, or an image that cannot be read.
pub fn evaluate(dataset: &Dataset, models: &Models, targets: &[Target], estimates: &[Estimate]) -> Result<Evaluation> {
    let detect = targets.first().is_some_and(|target| target.object.is_none());
    let asked = asked(dataset, targets, estimates)?;
    let shapes = shapes(models, &asked)?;
    let mut notes = Vec::new();
    let images: BTreeSet<(u32, u32)> = asked.keys().map(|&(scene, image, _)| (scene, image)).collect();
    let without = images.iter().filter(|&&(scene, image)| !dataset.has_depth(scene, image)).count();
    let deep = without == 0 && !detect;
    if !deep && !detect {
        notes.push(format!(
            "VSD, and the average recall that it enters, left out: {without} of {} images have no depth",
            images.len()
        ));
    }
    if dataset.frames().any(|(_, _, frame)| frame.truths.iter().any(|truth| truth.visible.is_none())) {
        notes.push("no scene_gt_info.json: every object counts as wholly visible".to_owned());
    }
    let groups: Vec<Group> = asked
        .par_iter()
        .map(|(&(scene, image, object), &count)| {
            let (model, shape) = shapes.get(&object).map_or((None, None), |(model, shape)| (Some(*model), Some(shape)));
            group::Question { dataset, scene, image, object, count, deep }.answer(model, shape, estimates)
        })
        .collect::<Result<_>>()?;
    let without_target = estimates.iter().filter(|e| !asked.contains_key(&(e.scene, e.image, e.object))).count();
    let mut objects: BTreeMap<u32, Vec<&Group>> = BTreeMap::new();
    for group in &groups {
        objects.entry(group.object).or_default().push(group);
    }
    let all: Vec<&Group> = groups.iter().collect();
    Ok(Evaluation {
        scores: (!detect).then(|| Scores::new(&all, deep)),
        objects: if detect {
            BTreeMap::new()
        } else {
            objects.iter().map(|(&object, groups)| (object, Scores::new(groups, deep))).collect()
        },
        detection: detect.then(|| Detection::new(&objects)),
        seconds_per_image: seconds(estimates, &images),
        estimates_without_target: without_target,
        notes,
        groups,
    })
}

/// How many of which object are to be found in which image; `None` for all of them.
type Asked = BTreeMap<(u32, u32, u32), Option<usize>>;

fn asked(dataset: &Dataset, targets: &[Target], estimates: &[Estimate]) -> Result<Asked> {
    let mut asked = Asked::new();
    for target in targets {
        let (scene, image) = (target.scene, target.image);
        let frame = dataset.frame(scene, image).ok_or_else(|| {
            let problem = format!("image {image} of scene {scene} is a target and not in the dataset");
            SceneError::new(dataset.root.display().to_string(), problem, "name the targets of this split by --targets")
        })?;
        if let Some(object) = target.object {
            asked.insert((scene, image, object), target.count);
            if !frame.truths.iter().any(|truth| truth.object == object) {
                let problem = format!("object {object} is a target in image {image} and has no pose there");
                let file = format!("{}/{scene:06}/scene_gt.json", dataset.split);
                return Err(SceneError::new(
                    file,
                    problem,
                    "use a split whose poses are public, or correct the targets",
                ));
            }
        } else {
            asked.extend(frame.truths.iter().map(|truth| ((scene, image, truth.object), None)));
            let here = estimates.iter().filter(|e| (e.scene, e.image) == (scene, image));
            asked.extend(surest(here).map(|e| ((scene, image, e.object), None)));
        }
    }
    Ok(asked)
}

/// The estimates that BOP24 looks at.
fn surest<'a>(estimates: impl Iterator<Item = &'a Estimate>) -> impl Iterator<Item = &'a Estimate> {
    let mut sorted: Vec<&Estimate> = estimates.collect();
    sorted.sort_by(|a, b| b.score.total_cmp(&a.score));
    sorted.into_iter().take(MOST_DETECTIONS)
}

fn shapes<'a>(models: &'a Models, asked: &Asked) -> Result<BTreeMap<u32, (&'a Model, Shape)>> {
    let objects: BTreeSet<u32> = asked.keys().map(|&(_, _, object)| object).collect();
    let shape = |object: u32| match models.get(&object) {
        Some(model) => Ok((object, (model, Shape::new(model)))),
        None => {
            let problem = format!("has no object {object}, which is a target or an estimate in a target's image");
            Err(SceneError::new("models_info.json", problem, "add its model, or correct the number"))
        }
    };
    objects.into_iter().map(shape).collect()
}

/// The time of an image is the same in all of its rows, so the largest is taken.
fn seconds(estimates: &[Estimate], images: &BTreeSet<(u32, u32)>) -> Option<f64> {
    let mut times: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    for estimate in estimates.iter().filter(|e| images.contains(&(e.scene, e.image))) {
        if let Some(seconds) = estimate.seconds {
            let longest = times.entry((estimate.scene, estimate.image)).or_insert(seconds);
            *longest = longest.max(seconds);
        }
    }
    let count = u32::try_from(times.len()).ok().filter(|&count| count > 0)?;
    Some(times.values().sum::<f64>() / f64::from(count))
}
