//! One scene: `scene_camera.json`, and where they exist `scene_gt.json` and `scene_gt_info.json`.

use super::json::{numbered, read};
use super::unit::metres;
use crate::{Intrinsics, Pose};
use gonio_scene::files::Files;
use gonio_scene::{Result, SceneError};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Images taken of one arrangement of objects.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// By the image's number.
    pub frames: BTreeMap<u32, Frame>,
}

/// What is known of one image besides its pixels.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Of the colour and the depth image alike.
    pub camera: Intrinsics,
    /// Metres of one step of the depth image.
    pub depth_step: f64,
    /// The objects in it, in the file's order; empty where the file states none.
    pub truths: Vec<Truth>,
}

/// An object in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// The object's number.
    pub object: u32,
    /// From the model to the camera.
    pub pose: Pose,
    /// Visible part of its silhouette, 0 to 1; `None` where `scene_gt_info.json` is missing.
    pub visible: Option<f64>,
}

#[derive(Deserialize)]
struct CameraEntry {
    #[serde(rename = "cam_K")]
    k: [f64; 9],
    depth_scale: Option<f64>,
}

#[derive(Deserialize)]
struct TruthEntry {
    obj_id: u32,
    #[serde(rename = "cam_R_m2c")]
    rotation: [f64; 9],
    #[serde(rename = "cam_t_m2c")]
    translation: [f64; 3],
}

#[derive(Deserialize)]
struct InfoEntry {
    visib_fract: f64,
}

impl Scene {
    /// Reads the scene in `folder`. `has` tells whether a file exists: all but `scene_camera.json` may be missing.
    ///
    /// # Errors
    /// No such scene, no JSON, a key that is missing or of another kind, a camera or rotation that is none, or files that
    /// do not belong together.
    pub fn read(files: &dyn Files, folder: &str, has: &dyn Fn(&str) -> bool) -> Result<Self> {
        let path = format!("{folder}/scene_camera.json");
        let mut frames = BTreeMap::new();
        for (image, entry) in numbered(&path, read::<BTreeMap<String, CameraEntry>>(files, &path)?)? {
            let frame = frame(&entry)
                .map_err(|(key, problem, mend)| SceneError::new(&path, problem, mend).at(format!("{image}.{key}")))?;
            frames.insert(image, frame);
        }
        let mut scene = Self { frames };
        let path = format!("{folder}/scene_gt.json");
        if has(&path) {
            scene.add_truths(&path, numbered(&path, read(files, &path)?)?)?;
            let path = format!("{folder}/scene_gt_info.json");
            if has(&path) {
                scene.add_visibility(&path, &numbered(&path, read(files, &path)?)?)?;
            }
        }
        Ok(scene)
    }

    fn add_truths(&mut self, path: &str, entries: BTreeMap<u32, Vec<TruthEntry>>) -> Result<()> {
        for (image, list) in entries {
            let Some(frame) = self.frames.get_mut(&image) else {
                let mend = "add the image to scene_camera.json, or remove it here";
                return Err(SceneError::new(path, "is an image without a camera", mend).at(image.to_string()));
            };
            for (index, entry) in list.iter().enumerate() {
                let pose = Pose::from_rows(&entry.rotation, entry.translation.map(metres)).ok_or_else(|| {
                    let mend = "write nine numbers row by row, and a finite translation in millimetres";
                    SceneError::new(path, "is no rotation", mend).at(format!("{image}[{index}].cam_R_m2c"))
                })?;
                frame.truths.push(Truth { object: entry.obj_id, pose, visible: None });
            }
        }
        Ok(())
    }

    fn add_visibility(&mut self, path: &str, entries: &BTreeMap<u32, Vec<InfoEntry>>) -> Result<()> {
        for (image, frame) in &mut self.frames {
            let list = entries.get(image).map_or(&[][..], Vec::as_slice);
            if list.len() != frame.truths.len() {
                let problem = format!("has {} entries for the {} of scene_gt.json", list.len(), frame.truths.len());
                return Err(SceneError::new(path, problem, "write one entry per object").at(image.to_string()));
            }
            for (index, (truth, entry)) in frame.truths.iter_mut().zip(list).enumerate() {
                if !(0.0..=1.0).contains(&entry.visib_fract) {
                    let problem = format!("is {}, must lie in 0..=1", entry.visib_fract);
                    let key = format!("{image}[{index}].visib_fract");
                    return Err(SceneError::new(path, problem, "write the visible part of the silhouette").at(key));
                }
                truth.visible = Some(entry.visib_fract);
            }
        }
        Ok(())
    }
}

fn frame(entry: &CameraEntry) -> std::result::Result<Frame, (&'static str, String, &'static str)> {
    let k = entry.k;
    if !(k.iter().all(|x| x.is_finite()) && k[0] > 0.0 && k[4] > 0.0 && k[1] == 0.0) {
        let mend = "write [fx, 0, cx, 0, fy, cy, 0, 0, 1] with positive focal lengths";
        return Err(("cam_K", "is no calibration matrix without skew".to_owned(), mend));
    }
    let scale = entry.depth_scale.unwrap_or(1.0);
    if !(scale.is_finite() && scale > 0.0) {
        return Err(("depth_scale", format!("is {scale}"), "write the millimetres of one step, above 0"));
    }
    let camera = Intrinsics { fx: k[0], fy: k[4], cx: k[2], cy: k[5] };
    Ok(Frame { camera, depth_step: metres(scale), truths: Vec::new() })
}
