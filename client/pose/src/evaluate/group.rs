//! One object in one image: how many are to be found, and how far every estimate is from every one of them.

use super::surest;
use crate::Pose;
use crate::bop::{Dataset, Estimate, Model};
use crate::errors::{self, Shape, TAUS};
use gonio_scene::{Result, SceneError};

/// Every object of one number in one image.
#[derive(Debug, Clone)]
pub struct Group {
    /// Number of the scene.
    pub scene: u32,
    /// Number of the image.
    pub image: u32,
    /// Number of the object.
    pub object: u32,
    /// Visible part of each, 0 to 1, in the order of the dataset.
    pub visible: Vec<f64>,
    /// Which of them are to be found: in BOP19 as many of the most visible as the target says, in BOP24 all.
    pub wanted: Vec<bool>,
    /// The estimates that count, surest first.
    pub scores: Vec<f64>,
    /// Every estimate of `scores` against every object of `visible`.
    pub pairs: Vec<Pair>,
}

/// An estimate held against a true pose.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// Index into the group's `scores`.
    pub estimate: usize,
    /// Index into the group's `visible`.
    pub truth: usize,
    /// How far they are apart.
    pub errors: Errors,
}

/// How far an estimate is from a true pose.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    /// For each tolerance of [`TAUS`], 0 to 1; `None` without depth.
    pub vsd: Option<[f64; TAUS.len()]>,
    /// In metres.
    pub mssd: f64,
    /// In pixels of the image.
    pub mspd: f64,
    /// In metres.
    pub add: f64,
    /// In metres.
    pub add_s: f64,
    /// In pixels of the image.
    pub projection: f64,
    /// In degrees.
    pub rotation: f64,
    /// In metres.
    pub translation: f64,
    /// Of the model, in metres.
    pub diameter: f64,
    /// Whether the model has symmetries, so that ADD-S is the one that counts.
    pub symmetric: bool,
    /// Of the image, in pixels.
    pub width: u32,
}

impl Group {
    /// For each true pose, the estimate that finds it: greedily, the surest first, each takes the nearest wanted pose that
    /// is free and whose `error` is below `threshold`.
    pub fn matches(&self, threshold: f64, error: impl Fn(&Errors) -> f64) -> Vec<Option<usize>> {
        let mut found = vec![None; self.visible.len()];
        let each = self.visible.len();
        // Pairs are in the order of the estimates, each with every truth.
        for pairs in self.pairs.chunks(each.max(1)) {
            let mut best = threshold;
            let mut nearest = None;
            for pair in pairs {
                let free = found.get(pair.truth).is_some_and(Option::is_none);
                let error = error(&pair.errors);
                if free && self.wanted.get(pair.truth) == Some(&true) && error < best {
                    best = error;
                    nearest = Some(pair);
                }
            }
            if let Some(pair) = nearest
                && let Some(place) = found.get_mut(pair.truth)
            {
                *place = Some(pair.estimate);
            }
        }
        found
    }

    /// How many are to be found.
    #[must_use]
    pub fn targets(&self) -> usize {
        self.wanted.iter().filter(|&&wanted| wanted).count()
    }
}

/// What is asked about an object in an image.
pub(super) struct Question<'a> {
    pub dataset: &'a Dataset,
    pub scene: u32,
    pub image: u32,
    pub object: u32,
    /// How many are to be found; all where absent (BOP24).
    pub count: Option<usize>,
    /// Whether to compute VSD.
    pub deep: bool,
}

impl Question<'_> {
    /// Computes every error. Model and shape are present for every object that is asked for.
    pub fn answer(&self, model: Option<&Model>, shape: Option<&Shape>, estimates: &[Estimate]) -> Result<Group> {
        let Self { scene, image, object, .. } = *self;
        let missing = || SceneError::new("models_info.json", format!("has no object {object}"), "add its model");
        let (model, shape) = (model.ok_or_else(missing)?, shape.ok_or_else(missing)?);
        let frame = self.dataset.frame(scene, image).ok_or_else(missing)?;
        let truths: Vec<_> = frame.truths.iter().filter(|truth| truth.object == object).collect();
        let visible: Vec<f64> = truths.iter().map(|truth| truth.visible.unwrap_or(1.0)).collect();
        let estimates = self.counted(estimates);
        let depth = if self.deep { self.dataset.depth(scene, image)? } else { None };
        let mut pairs = Vec::new();
        let width = if estimates.is_empty() { 0 } else { self.dataset.size(scene, image)?.0 };
        let symmetric = !(model.discrete.is_empty() && model.continuous.is_empty());
        for (index, (_, estimate)) in estimates.iter().enumerate() {
            for (truth, pose) in truths.iter().map(|truth| &truth.pose).enumerate() {
                let errors = Errors {
                    vsd: depth
                        .as_ref()
                        .map(|depth| errors::vsd(&model.mesh, shape.diameter, estimate, pose, &frame.camera, depth)),
                    mssd: shape.mssd(estimate, pose),
                    mspd: shape.mspd(estimate, pose, &frame.camera),
                    add: shape.add(estimate, pose),
                    add_s: shape.add_s(estimate, pose),
                    projection: shape.projection(estimate, pose, &frame.camera),
                    rotation: errors::rotation(estimate, pose),
                    translation: errors::translation(estimate, pose),
                    diameter: shape.diameter,
                    symmetric,
                    width,
                };
                pairs.push(Pair { estimate: index, truth, errors });
            }
        }
        let wanted = wanted(&visible, self.count);
        let scores = estimates.iter().map(|(score, _)| *score).collect();
        Ok(Group { scene, image, object, visible, wanted, scores, pairs })
    }

    /// The estimates of this object that count, surest first: as many as are to be found.
    fn counted(&self, estimates: &[Estimate]) -> Vec<(f64, Pose)> {
        let here = estimates.iter().filter(|e| (e.scene, e.image) == (self.scene, self.image));
        let mine = |e: &&Estimate| e.object == self.object;
        let known = |e: &Estimate| (e.score, e.pose);
        match self.count {
            None => surest(here).filter(mine).map(known).collect(),
            Some(count) => {
                let mut sorted: Vec<_> = here.filter(mine).map(known).collect();
                sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
                sorted.truncate(count);
                sorted
            }
        }
    }
}

/// The `count` most visible, the first of equals.
fn wanted(visible: &[f64], count: Option<usize>) -> Vec<bool> {
    let mut order: Vec<usize> = (0..visible.len()).collect();
    order.sort_by(|&a, &b| visible.get(b).unwrap_or(&0.0).total_cmp(visible.get(a).unwrap_or(&0.0)));
    let chosen = order.get(..count.unwrap_or(order.len()).min(order.len())).unwrap_or_default();
    (0..visible.len()).map(|index| chosen.contains(&index)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(distances: &[&[f64]], wanted: &[bool]) -> Group {
        let errors = |mssd| Errors {
            vsd: None,
            mssd,
            mspd: 0.0,
            add: 0.0,
            add_s: 0.0,
            projection: 0.0,
            rotation: 0.0,
            translation: 0.0,
            diameter: 1.0,
            symmetric: false,
            width: 640,
        };
        let pair = |estimate, (truth, &mssd): (usize, &f64)| Pair { estimate, truth, errors: errors(mssd) };
        let row =
            |(estimate, row): (usize, &&[f64])| row.iter().enumerate().map(|p| pair(estimate, p)).collect::<Vec<_>>();
        Group {
            scene: 1,
            image: 1,
            object: 1,
            visible: vec![1.0; wanted.len()],
            wanted: wanted.to_vec(),
            scores: vec![1.0; distances.len()],
            pairs: distances.iter().enumerate().flat_map(row).collect(),
        }
    }

    #[test]
    fn the_surest_chooses_first_and_takes_the_nearest() {
        let group = group(&[&[0.2, 0.1], &[0.3, 0.05], &[0.1, 0.1]], &[true, true]);
        assert_eq!(group.matches(0.5, |e| e.mssd), [Some(1), Some(0)]);
        // 0.2 and 0.3 are not below 0.15; the third takes what is left.
        assert_eq!(group.matches(0.15, |e| e.mssd), [Some(2), Some(0)]);
        // Below, not at.
        assert_eq!(group.matches(0.1, |e| e.mssd), [None, Some(1)]);
    }

    #[test]
    fn what_is_not_wanted_is_not_found() {
        let group = group(&[&[0.1, 0.2]], &[false, true]);
        assert_eq!(group.matches(0.5, |e| e.mssd), [None, Some(0)]);
    }

    #[test]
    fn the_most_visible_are_wanted() {
        assert_eq!(wanted(&[0.2, 0.9, 0.5], Some(2)), [false, true, true]);
        assert_eq!(wanted(&[0.5, 0.5], Some(1)), [true, false]);
        assert_eq!(wanted(&[0.5, 0.5], Some(7)), [true, true]);
        assert_eq!(wanted(&[0.0, 0.5], None), [true, true]);
    }
}
