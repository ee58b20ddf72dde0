//! A dataset's own files, for those who make one.

use super::unit::millimetres;
use crate::{Intrinsics, Pose};
use glam::DVec3;
use gonio_scene::mesh::{Mesh, write_ply};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// What `scene_gt_info.json` says of an object in an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Visibility {
    /// Pixels of the whole silhouette, out of the image too.
    pub all: u64,
    /// Those in the image whose depth is known.
    pub valid: u64,
    /// Those in the image that nothing hides.
    pub visible: u64,
    /// Bounding box of the whole silhouette: column, row (the image's corner is 0, 0), width, height; -1 where it is nowhere.
    pub all_box: [i64; 4],
    /// Bounding box of what is visible.
    pub visible_box: [i64; 4],
}

impl Visibility {
    /// Visible part of the silhouette, 0 to 1.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        #[allow(clippy::cast_precision_loss)] // pixels
        if self.all == 0 { 0.0 } else { self.visible as f64 / self.all as f64 }
    }
}

/// An object where it is in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// The model's number.
    pub object: u32,
    /// From the model to the camera.
    pub pose: Pose,
    /// How much of it is seen.
    pub visibility: Visibility,
}

/// An image of a scene that is written.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneImage {
    /// Its camera.
    pub camera: Intrinsics,
    /// Metres of one step of its depth image.
    pub depth_step: f64,
    /// What is in it.
    pub instances: Vec<Instance>,
}

/// `scene_camera.json`, `scene_gt.json` and `scene_gt_info.json` of a scene, by the image's number.
#[must_use]
pub fn scene_files(images: &BTreeMap<u32, SceneImage>) -> [(&'static str, String); 3] {
    let list = |of: &dyn Fn(&SceneImage) -> Value| {
        let lines: Vec<String> =
            images.iter().map(|(number, image)| format!("  \"{number}\": {}", of(image))).collect();
        format!("{{\n{}\n}}\n", lines.join(",\n"))
    };
    let each = |image: &SceneImage, of: &dyn Fn(&Instance) -> Value| image.instances.iter().map(of).collect::<Value>();
    [
        ("scene_camera.json", list(&|image| camera(&image.camera, image.depth_step))),
        ("scene_gt.json", list(&|image| each(image, &truth))),
        ("scene_gt_info.json", list(&|image| each(image, &info))),
    ]
}

fn camera(c: &Intrinsics, step: f64) -> Value {
    json!({ "cam_K": [c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0], "depth_scale": millimetres(step) })
}

fn truth(instance: &Instance) -> Value {
    json!({
        "cam_R_m2c": instance.pose.rows(),
        "cam_t_m2c": instance.pose.translation.to_array().map(millimetres),
        "obj_id": instance.object,
    })
}

fn info(instance: &Instance) -> Value {
    let v = &instance.visibility;
    json!({
        "bbox_obj": v.all_box,
        "bbox_visib": v.visible_box,
        "px_count_all": v.all,
        "px_count_valid": v.valid,
        "px_count_visib": v.visible,
        "visib_fract": v.fraction(),
    })
}

/// A model as `models_info.json` has it, but for its number.
#[derive(Debug, Clone, Copy)]
pub struct ModelInfo<'a> {
    /// In metres.
    pub mesh: &'a Mesh,
    /// Motions onto itself, without the identity.
    pub discrete: &'a [Pose],
    /// Axes of any turn: direction, and a point in metres.
    pub continuous: &'a [([f64; 3], [f64; 3])],
}

/// `models_info.json`.
#[must_use]
pub fn models_info(models: &BTreeMap<u32, ModelInfo<'_>>) -> String {
    let entry = |(id, model): (&u32, &ModelInfo<'_>)| {
        let points: Vec<DVec3> = points(model.mesh).collect();
        let (low, high) =
            points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let mut map = Map::new();
        map.insert("diameter".to_owned(), json!(millimetres(diameter(&points))));
        for (axis, low, size) in
            [("x", low.x, high.x - low.x), ("y", low.y, high.y - low.y), ("z", low.z, high.z - low.z)]
        {
            map.insert(format!("min_{axis}"), json!(millimetres(low)));
            map.insert(format!("size_{axis}"), json!(millimetres(size)));
        }
        if !model.discrete.is_empty() {
            let motions: Vec<Vec<f64>> = model.discrete.iter().map(matrix).collect();
            map.insert("symmetries_discrete".to_owned(), json!(motions));
        }
        if !model.continuous.is_empty() {
            let axis =
                |(axis, offset): &([f64; 3], [f64; 3])| json!({ "axis": axis, "offset": offset.map(millimetres) });
            map.insert("symmetries_continuous".to_owned(), model.continuous.iter().map(axis).collect());
        }
        (id.to_string(), Value::Object(map))
    };
    // Numbers in their order, which text does not keep.
    let lines: Vec<String> = models.iter().map(entry).map(|(id, value)| format!("  \"{id}\": {value}")).collect();
    format!("{{\n{}\n}}\n", lines.join(",\n"))
}

fn matrix(pose: &Pose) -> Vec<f64> {
    let (r, t) = (pose.rows(), pose.translation.to_array().map(millimetres));
    vec![r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2], 0.0, 0.0, 0.0, 1.0]
}

fn points(mesh: &Mesh) -> impl Iterator<Item = DVec3> {
    mesh.positions.iter().map(|position| DVec3::from_array(position.map(f64::from)))
}

/// Largest distance of two points, metres. Only those that are farthest in some direction can be its ends.
#[must_use]
pub fn diameter(points: &[DVec3]) -> f64 {
    let middle = points.iter().sum::<DVec3>() / f64::from(u32::try_from(points.len().max(1)).unwrap_or(u32::MAX));
    let mut far: Vec<(f64, DVec3)> = points.iter().map(|point| (point.distance(middle), *point)).collect();
    far.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut largest = 0f64;
    for (i, (radius, a)) in far.iter().enumerate() {
        // Neither this point nor any after it has a partner that is far enough.
        if far.first().is_some_and(|(most, _)| radius + most <= largest) {
            break;
        }
        for (other, b) in far.iter().skip(i + 1) {
            if radius + other <= largest {
                break;
            }
            largest = largest.max(a.distance(*b));
        }
    }
    largest
}

/// A mesh as a PLY in millimetres.
#[must_use]
pub fn ply(mesh: &Mesh) -> Vec<u8> {
    let mut scaled = mesh.clone();
    #[allow(clippy::cast_possible_truncation)] // positions are floats
    for value in scaled.positions.iter_mut().flatten() {
        *value = millimetres(f64::from(*value)) as f32;
    }
    write_ply(&scaled)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bop::{Model, Scene};
    use gonio_scene::files::MemoryFiles;

    #[test]
    fn a_scene_is_read_as_it_was_written() {
        let pose = Pose { rotation: glam::DMat3::from_rotation_y(0.3), translation: DVec3::new(0.01, -0.02, 0.5) };
        let visibility =
            Visibility { all: 40, valid: 40, visible: 10, all_box: [1, 2, 5, 8], visible_box: [1, 2, 5, 2] };
        let instances = vec![Instance { object: 7, pose, visibility }];
        let camera = Intrinsics { fx: 480.0, fy: 470.0, cx: 159.5, cy: 119.5 };
        let images = BTreeMap::from([(3, SceneImage { camera, depth_step: 1e-4, instances })]);
        let files = scene_files(&images).map(|(name, text)| (format!("s/{name}"), text.into_bytes().into()));
        let scene = Scene::read(&MemoryFiles(BTreeMap::from(files)), "s", &|_| true).unwrap();
        let frame = &scene.frames[&3];
        assert_eq!((frame.camera, frame.depth_step), (camera, 1e-4));
        assert_eq!((frame.truths[0].object, frame.truths[0].visible), (7, Some(0.25)));
        assert!((frame.truths[0].pose.translation - pose.translation).length() < 1e-15);
        assert_eq!(frame.truths[0].pose.rotation, pose.rotation);
    }

    #[test]
    fn a_model_is_read_as_it_was_written() {
        let positions = vec![[0.0, 0.0, 0.0], [0.03, 0.0, 0.0], [0.0, 0.04, 0.0], [0.01, 0.01, 0.01]];
        let normals = Some(vec![[0.0, 0.0, 1.0]; 4]);
        let mesh = Mesh { positions, normals, triangles: vec![[0, 1, 2], [1, 2, 3]], degenerate: 0 };
        let half = Pose { rotation: glam::DMat3::from_rotation_z(std::f64::consts::PI), translation: DVec3::X * 0.03 };
        let info = ModelInfo { mesh: &mesh, discrete: &[half], continuous: &[([0.0, 0.0, 1.0], [0.01, 0.0, 0.0])] };
        let text = models_info(&BTreeMap::from([(12, info)]));
        let files = [("m/models_info.json", text.into_bytes()), ("m/obj_000012.ply", ply(&mesh))];
        let files = files.map(|(name, bytes)| (name.to_owned(), bytes.into()));
        let files = MemoryFiles(BTreeMap::from(files));
        let models = Model::read_all(&files, "m").unwrap();
        let model = &models[&12];
        assert!((model.diameter - 0.05).abs() < 1e-8);
        assert_eq!(model.mesh.triangles, mesh.triangles);
        // The file holds the normals; evaluations need none, so they read none.
        assert_eq!(gonio_scene::mesh::read(&files, "m/obj_000012.ply").unwrap().normals, mesh.normals);
        assert_eq!(model.mesh.normals, None);
        for (a, b) in model.mesh.positions.iter().flatten().zip(mesh.positions.iter().flatten()) {
            assert!((a - b).abs() < 1e-8);
        }
        assert!((model.discrete[0].translation - half.translation).length() < 1e-12);
        assert!((model.continuous[0].1 - DVec3::X * 0.01).length() < 1e-12);
    }

    #[test]
    fn the_diameter_is_that_of_all_pairs() {
        let mut state = 7u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from((state >> 40) as u32) / f64::from(1 << 24)
        };
        let points: Vec<DVec3> = (0..300).map(|_| DVec3::new(unit(), 0.3 * unit(), unit())).collect();
        let pairs = points.iter().flat_map(|a| points.iter().map(move |b| a.distance(*b)));
        assert_eq!(diameter(&points), pairs.fold(0.0, f64::max));
    }
}
