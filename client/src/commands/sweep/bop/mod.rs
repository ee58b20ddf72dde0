//! The frames of a sweep as a dataset in the layout of the BOP benchmark.
//!
//! Colours are the frames' own files. Depth and masks need no light: they come from a z-buffer of the capture's meshes, at
//! the centres of the pixels, and are the same whoever rendered the frames.

mod labels;
mod visibility;

use super::input::Planned;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::to_pretty_json;
use crate::progress::Console;
use gonio_pose::Pose;
use gonio_pose::bop::{
    Depth, Instance, ModelInfo, SceneImage, Target, Visibility, encode_depth, models_info, ply, scene_files,
};
use gonio_pose::evaluate::LEAST_VISIBLE;
use gonio_scene::SceneError;
use gonio_scene::mesh::{self, Mesh};
use gonio_sweep::{FrameDigest, Label, Listed, Output};
use labels::labels;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use visibility::{Placed, mask, visibility};

/// The split that the frames are.
const SPLIT: &str = "test";

/// Metres of a step of the depth images: 6.5 m is the farthest.
const DEPTH_STEP: f64 = 1e-4;

/// A sweep's dataset.
pub(super) struct Dataset<'a> {
    planned: &'a Planned,
    folder: &'a Path,
    meshes: BTreeMap<String, Mesh>,
    labels: Vec<Label>,
}

impl<'a> Dataset<'a> {
    /// The dataset of a sweep, below `folder`; nothing is written yet.
    ///
    /// # Errors
    /// No model is listed, a camera that the format cannot hold, a mesh that cannot be read.
    pub fn new(planned: &'a Planned, sweep: &str, folder: &'a Path) -> Result<Self, Failure> {
        let plan = &planned.plan;
        let refuse =
            |key: &str, problem: &str, mend: &str| Failure::from(SceneError::new(sweep, problem, mend).at(key));
        if plan.models.is_empty() {
            let mend = "list what is to be found: [[model]] with id = 1 and objects = [\"NAME\"]";
            return Err(refuse("model", "is missing, which --format bop needs", mend));
        }
        let mut ids: Vec<u32> = plan.models.iter().map(|model| model.id).collect();
        ids.sort_unstable();
        if ids.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err(refuse("model", "has an id twice", "number the models"));
        }
        if !plan.outputs.contains(&Output::Rgb) {
            let mend = "add \"rgb\" to outputs: the images as a camera would save them";
            return Err(refuse("outputs", "has no \"rgb\", which --format bop needs", mend));
        }
        if plan
            .frames
            .iter()
            .any(|frame| plan.capture.camera_of(&plan.capture.photos[frame.photo]).distortion.iter().any(|k| *k != 0.0))
        {
            let mend = "set distortion = [0, 0, 0, 0, 0] in [view.camera]: BOP's images are without";
            return Err(refuse("view", "has a camera with distortion", mend));
        }
        let mut meshes = BTreeMap::new();
        for object in &plan.capture.objects {
            if !meshes.contains_key(&object.mesh) {
                meshes.insert(object.mesh.clone(), mesh::read(&planned.input.files, &object.mesh)?);
            }
        }
        Ok(Self { planned, folder, meshes, labels: labels(plan) })
    }

    /// Writes the dataset; the frames are there.
    ///
    /// # Errors
    /// A file that cannot be written, Ctrl-C.
    pub fn write(&self, console: &mut Console, interrupt: &Interrupt) -> Result<(), Failure> {
        let plan = &self.planned.plan;
        let scenes: BTreeMap<u32, String> =
            self.labels.iter().map(|label| (label.scene, format!("{SPLIT}/{:06}", label.scene))).collect();
        for folder in scenes.values() {
            for kind in ["rgb", "depth", "mask", "mask_visib"] {
                create(&self.folder.join(folder).join(kind))?;
            }
        }
        create(&self.folder.join("models"))?;
        self.write_models()?;
        console.begin("dataset");
        let (done, all) = (AtomicU64::new(0), plan.frames.len() as u64);
        let console = Mutex::new(console);
        let images: Result<Vec<(Label, SceneImage)>, Failure> = (0..plan.frames.len())
            .into_par_iter()
            .map(|index| {
                if interrupt.is_asked() {
                    let text = "interrupted: all frames are there; the same command writes the dataset anew";
                    return Err(Failure::Interrupted(text.to_owned()));
                }
                let image = self.write_image(index, &scenes)?;
                let position = done.fetch_add(1, Ordering::Relaxed) + 1;
                console.lock().unwrap_or_else(PoisonError::into_inner).show(
                    position,
                    all,
                    &format!("{position}/{all}"),
                    || serde_json::json!({ "event": "progress", "images_done": position, "images": all }),
                );
                Ok((self.labels[index], image))
            })
            .collect();
        console.into_inner().unwrap_or_else(PoisonError::into_inner).end();
        let mut by_scene: BTreeMap<u32, BTreeMap<u32, SceneImage>> = BTreeMap::new();
        for (label, image) in images? {
            by_scene.entry(label.scene).or_default().insert(label.image, image);
        }
        for (scene, images) in &by_scene {
            for (name, text) in scene_files(images) {
                self.put(&format!("{}/{name}", scenes[scene]), text.as_bytes())?;
            }
        }
        self.put("test_targets_bop19.json", targets(&by_scene)?.as_bytes())?;
        self.put("bop_frames.csv", self.table().as_bytes())
    }

    fn write_models(&self) -> Result<(), Failure> {
        let mut infos = BTreeMap::new();
        for model in &self.planned.plan.models {
            let Some(mesh) = self.mesh_of(model) else { continue };
            self.put(&format!("models/obj_{:06}.ply", model.id), &ply(mesh))?;
            infos.insert(model.id, ModelInfo { mesh, discrete: &model.discrete, continuous: &model.continuous });
        }
        self.put("models/models_info.json", models_info(&infos).as_bytes())
    }

    fn mesh_of(&self, model: &Listed) -> Option<&Mesh> {
        let name = model.objects.first()?;
        let object = self.planned.plan.capture.objects.iter().find(|object| object.name == *name)?;
        self.meshes.get(&object.mesh)
    }

    fn write_image(&self, index: usize, scenes: &BTreeMap<u32, String>) -> Result<SceneImage, Failure> {
        let plan = &self.planned.plan;
        let (frame, label) = (&plan.frames[index], self.labels[index]);
        let mut capture = plan.capture.clone();
        capture.set_numbers(&plan.numbers(frame))?;
        let photo = &capture.photos[frame.photo];
        let camera = capture.camera_of(photo);
        let intrinsics = Listed::intrinsics(&capture, photo);
        let size = (camera.width, camera.height);
        let digest: FrameDigest = self.planned.digests[index];
        let (scene, image) = (&scenes[&label.scene], label.image);
        let colours = self.folder.join(digest.path(Output::Rgb.ending()));
        let bytes = std::fs::read(&colours)
            .map_err(|error| Failure::Failed(format!("{}: cannot be read: {error}", colours.display())))?;
        self.put(&format!("{scene}/rgb/{image:06}.png"), &bytes)?;
        // What each object hides, and what hides it.
        let mut nearest = vec![0f32; size.0 as usize * size.1 as usize];
        let mut depths: BTreeMap<&str, (Pose, Vec<f32>)> = BTreeMap::new();
        for object in capture.objects.iter().filter(|object| object.presence > 0.0) {
            let Some(mesh) = self.meshes.get(&object.mesh) else { continue };
            let metres = Placed::new(&object.placement(), &photo.pose()).depth(mesh, &intrinsics, size);
            for (near, &z) in nearest.iter_mut().zip(&metres) {
                if z > 0.0 && (*near == 0.0 || z < *near) {
                    *near = z;
                }
            }
            if let Some(pose) = Listed::pose(&object.placement(), photo) {
                depths.insert(object.name.as_str(), (pose, metres));
            }
        }
        let mut instances = Vec::new();
        for (model, name) in plan.models.iter().flat_map(|model| model.objects.iter().map(move |name| (model, name))) {
            let Some((pose, own)) = depths.get(name.as_str()) else {
                let problem = format!("\"{name}\" is scaled at this point, which BOP's poses cannot say");
                return Err(Failure::Input(problem + "; give the mesh the right size"));
            };
            let seen: Vec<bool> = own.iter().zip(&nearest).map(|(z, near)| *z > 0.0 && z <= near).collect();
            let whole: Vec<bool> = own.iter().map(|z| *z > 0.0).collect();
            let number = instances.len();
            let name = format!("{image:06}_{number:06}.png");
            self.put(&format!("{scene}/mask/{name}"), &mask(&whole, size)?)?;
            self.put(&format!("{scene}/mask_visib/{name}"), &mask(&seen, size)?)?;
            let visibility = match self.mesh_of(model) {
                Some(mesh) => visibility(mesh, pose, &intrinsics, size, &whole, &seen),
                None => Visibility::default(),
            };
            instances.push(Instance { object: model.id, pose: *pose, visibility });
        }
        let depth = Depth { width: size.0, height: size.1, metres: nearest };
        let path = format!("{scene}/depth/{image:06}.png");
        self.put(&path, &encode_depth(&path, &depth, DEPTH_STEP)?)?;
        Ok(SceneImage { camera: intrinsics, depth_step: DEPTH_STEP, instances })
    }

    /// Which frame is which image.
    fn table(&self) -> String {
        let plan = &self.planned.plan;
        let mut text = "scene_id,im_id,frame,point,view,digest\n".to_owned();
        for (index, (frame, label)) in plan.frames.iter().zip(&self.labels).enumerate() {
            let (view, digest) = (plan.capture.photos[frame.photo].name(), self.planned.digests[index]);
            let _ = writeln!(text, "{},{},{index},{},{view},{digest}", label.scene, label.image, frame.point);
        }
        text
    }

    fn put(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        super::super::prepare::write(&self.folder.join(name), bytes)
    }
}

fn create(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::Failed(format!("{}: cannot be created: {error}", folder.display())))
}

/// What is to be found: every object that is visible by a tenth.
fn targets(scenes: &BTreeMap<u32, BTreeMap<u32, SceneImage>>) -> Result<String, Failure> {
    let mut targets = Vec::new();
    for (&scene, images) in scenes {
        for (&image, content) in images {
            let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
            for instance in content.instances.iter().filter(|i| i.visibility.fraction() >= LEAST_VISIBLE) {
                *counts.entry(instance.object).or_default() += 1;
            }
            let target = |(object, count)| Target { scene, image, object: Some(object), count: Some(count) };
            targets.extend(counts.into_iter().map(target));
        }
    }
    Ok(to_pretty_json(&targets)? + "\n")
}
