//! The estimator that is built in.

use super::{Method, Task, colours, objects};
use crate::failure::Failure;
use gonio_estimate::{Estimator, Settings};
use gonio_pose::bop::{Dataset, Estimate, Models};
use gonio_scene::SceneError;
use std::collections::BTreeMap;
use std::time::Instant;

/// Templates of every object that is asked for.
pub(super) struct BuiltIn<'a> {
    dataset: &'a Dataset,
    estimators: BTreeMap<u32, Estimator>,
    settings: Settings,
}

impl<'a> BuiltIn<'a> {
    /// Of the models of `dataset` that `tasks` ask for.
    ///
    /// # Errors
    /// An object without a model.
    pub fn new(dataset: &'a Dataset, models: &Models, tasks: &[Task], settings: Settings) -> Result<Self, Failure> {
        let mut estimators = BTreeMap::new();
        for object in objects(tasks) {
            let model = models.get(&object).ok_or_else(|| {
                let mend = "add the model and its diameter, or leave the object out of the targets";
                SceneError::new("models_info.json", "has no such object", mend).at(object.to_string())
            })?;
            estimators.insert(object, Estimator::new(model));
        }
        Ok(Self { dataset, estimators, settings })
    }
}

impl Method for BuiltIn<'_> {
    fn estimate(&self, task: &Task) -> Result<Vec<Estimate>, Failure> {
        let begin = Instant::now();
        colours(self.dataset, task)?;
        let image = self.dataset.colour(task.scene, task.image)?;
        let Some(frame) = self.dataset.frame(task.scene, task.image) else {
            let mend = "add its camera, or leave the image out of the targets";
            let file = format!("{}/{:06}/scene_camera.json", self.dataset.split, task.scene);
            return Err(SceneError::new(file, "has no such image", mend).at(task.image.to_string()).into());
        };
        let mut estimates = Vec::new();
        for (&object, &count) in &task.objects {
            let Some(estimator) = self.estimators.get(&object) else { continue };
            for found in estimator.find(&image, &frame.camera, &self.settings).into_iter().take(count) {
                let (scene, image) = (task.scene, task.image);
                estimates.push(Estimate { scene, image, object, score: found.score, pose: found.pose, seconds: None });
            }
        }
        let seconds = Some(begin.elapsed().as_secs_f64());
        estimates.iter_mut().for_each(|estimate| estimate.seconds = seconds);
        Ok(estimates)
    }
}
