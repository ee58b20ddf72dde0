//! The views of a BOP dataset: cameras that see a part as those of the dataset do.

use crate::keys::Keys;
use crate::plan::Label;
use glam::DMat3;
use gonio_pose::bop::{Frame, Scene};
use gonio_pose::{Intrinsics, Pose};
use gonio_scene::capture::{CameraOverride, Range};
use gonio_scene::files::Files;
use gonio_scene::{Capture, Result, SceneError};

/// A capture counts pixels from their edges, BOP from their centres.
const HALF_PIXEL: f64 = 0.5;

/// A scene of a dataset, and which of its objects is which of the capture's.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Source {
    /// The sweep's file and where it names this, for errors.
    file: String,
    place: String,
    /// Folder of the scene, relative to the sweep's file.
    folder: String,
    scene: u32,
    /// The object's number in the dataset.
    number: u32,
    /// The object's name in the capture.
    object: String,
    /// What is added to the dataset's principal point to count pixels from their edges.
    offset: f64,
    /// Width and height of its images; those of the capture's camera where absent.
    size: Option<[u32; 2]>,
}

/// A view like that of an image.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Repeated {
    pub label: Label,
    pub camera_to_world: [[f64; 4]; 4],
    intrinsics: Intrinsics,
    offset: f64,
    size: Option<[u32; 2]>,
}

impl Source {
    pub fn read(keys: &mut Keys<'_>) -> Result<Self> {
        let folder = keys.text("scene")?;
        let folder = keys.needed("scene", folder, "the folder of a dataset's scene, such as \"real/test/000001\"")?;
        let folder = folder.trim_end_matches('/').to_owned();
        let scene = folder.rsplit('/').next().and_then(|name| name.parse().ok());
        let mend = "name the folder that holds scene_gt.json; its own name is the scene's number";
        let scene = scene.ok_or_else(|| keys.refuse("scene", format!("is \"{folder}\""), mend))?;
        let object = keys.text("object")?;
        let object = keys.needed("object", object, "the name of the capture's object whose poses these are")?;
        let size = keys.numbers("size", 2, Range { min: 1.0, max: f64::from(gonio_scene::MAX_SIDE) })?;
        Ok(Self {
            file: keys.file().to_owned(),
            place: keys.path().to_owned(),
            folder,
            scene,
            number: keys.whole("object_id", 0..=u64::from(u32::MAX))?.unwrap_or(1) as u32,
            object: object.to_owned(),
            offset: keys.number("principal_point_offset", Range { min: -1.0, max: 1.0 })?.unwrap_or(HALF_PIXEL),
            size: size.map(|size| [size[0] as u32, size[1] as u32]),
        })
    }

    /// The images in which the object is; of several of it, the first.
    pub fn images(&self, capture: &Capture, files: &dyn Files) -> Result<Vec<Repeated>> {
        let at = |key: &str| format!("{}.{key}", self.place);
        let Some(object) = capture.objects.iter().find(|object| object.name == self.object) else {
            let known: Vec<&str> = capture.objects.iter().map(|object| object.name.as_str()).collect();
            let (problem, mend) = (format!("is \"{}\"", self.object), format!("the objects are: {}", known.join(", ")));
            return Err(SceneError::new(&self.file, problem, mend).at(at("object")));
        };
        let world = rigid(&object.placement()).ok_or_else(|| {
            let mend = "give the object a rotation and a translation, and its mesh the right size";
            SceneError::new(&self.file, format!("names \"{}\", which is scaled", self.object), mend).at(at("object"))
        })?;
        let scene = Scene::read(files, &self.folder, &|path| path.ends_with("scene_gt.json"))?;
        let seen = |(&image, frame): (&u32, &Frame)| {
            let truth = frame.truths.iter().find(|truth| truth.object == self.number)?;
            Some(Repeated {
                label: Label { scene: self.scene, image },
                camera_to_world: matrix(&world.after(&truth.pose.inverse())),
                intrinsics: frame.camera,
                offset: self.offset,
                size: self.size,
            })
        };
        let images: Vec<Repeated> = scene.frames.iter().filter_map(seen).collect();
        if images.is_empty() {
            let problem = format!("has no image of the object {}", self.number);
            let mend = "name another scene, or the object's number by object_id";
            return Err(SceneError::new(&self.file, problem, mend).at(at("scene")));
        }
        Ok(images)
    }
}

impl Repeated {
    /// The image's camera, but for keys that `own` has.
    pub fn camera(&self, own: &CameraOverride) -> CameraOverride {
        let Intrinsics { fx, fy, cx, cy } = self.intrinsics;
        CameraOverride {
            fx: own.fx.or(Some(fx)),
            fy: own.fy.or(Some(fy)),
            cx: own.cx.or(Some(cx + self.offset)),
            cy: own.cy.or(Some(cy + self.offset)),
            width: own.width.or(self.size.map(|size| size[0])),
            height: own.height.or(self.size.map(|size| size[1])),
            ..own.clone()
        }
    }
}

/// A placement as a motion; `None` where it scales.
fn rigid(m: &[[f64; 4]; 4]) -> Option<Pose> {
    let rows = [m[0][0], m[0][1], m[0][2], m[1][0], m[1][1], m[1][2], m[2][0], m[2][1], m[2][2]];
    Pose::from_rows(&rows, [m[0][3], m[1][3], m[2][3]])
}

fn matrix(pose: &Pose) -> [[f64; 4]; 4] {
    // A dataset's rotations have the digits of its file; a capture's are held against tighter bounds.
    let rotation = orthonormal(&pose.rotation);
    let (r, t) = (rotation.transpose().to_cols_array(), pose.translation);
    [[r[0], r[1], r[2], t.x], [r[3], r[4], r[5], t.y], [r[6], r[7], r[8], t.z], [0.0, 0.0, 0.0, 1.0]]
}

/// The rotation with its columns made orthonormal, the last one first: the line of sight stays.
fn orthonormal(r: &DMat3) -> DMat3 {
    let forward = r.z_axis.normalize();
    let right = (r.x_axis - forward * forward.dot(r.x_axis)).normalize();
    DMat3::from_cols(right, forward.cross(right), forward)
}

/// The motion of an object's mesh to a photo's camera.
pub(crate) fn model_to_camera(placement: &[[f64; 4]; 4], camera_to_world: &[[f64; 4]; 4]) -> Option<Pose> {
    Some(rigid(camera_to_world)?.inverse().after(&rigid(placement)?))
}

/// The camera of a capture as BOP counts pixels.
pub(crate) fn intrinsics(camera: &gonio_scene::capture::Camera) -> Intrinsics {
    Intrinsics { fx: camera.fx, fy: camera.fy, cx: camera.cx - HALF_PIXEL, cy: camera.cy - HALF_PIXEL }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_view_of_a_dataset_sees_the_object_where_the_dataset_has_it() {
        let object = Pose { rotation: DMat3::from_rotation_z(0.4), translation: DVec3::new(0.1, -0.2, 0.05) };
        let seen = Pose { rotation: DMat3::from_rotation_x(2.5), translation: DVec3::new(0.02, 0.01, 0.4) };
        let camera = matrix(&object.after(&seen.inverse()));
        let back = model_to_camera(&matrix(&object), &camera).unwrap();
        assert!((back.rotation - seen.rotation).to_cols_array().iter().all(|x| x.abs() < 1e-12));
        assert!((back.translation - seen.translation).length() < 1e-12);
    }
}
