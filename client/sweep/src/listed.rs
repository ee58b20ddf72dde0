//! The objects that a BOP dataset of a sweep lists.

use crate::keys::Keys;
use crate::view::model_to_camera;
use gonio_pose::{Intrinsics, Pose};
use gonio_scene::capture::{Photo, Range};
use gonio_scene::{Capture, Result, SceneError};

/// A model of the dataset: objects of the capture that are alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Listed {
    /// The model's number in the dataset.
    pub id: u32,
    /// Names of the objects; all have one mesh.
    pub objects: Vec<String>,
    /// Motions of the mesh onto itself, without the identity; rotation and metres.
    pub discrete: Vec<Pose>,
    /// Axes (direction, a point on it in metres) round which any turn maps the mesh onto itself.
    pub continuous: Vec<([f64; 3], [f64; 3])>,
    place: String,
}

impl Listed {
    /// Reads one `[[model]]`.
    pub(crate) fn read(mut keys: Keys<'_>) -> Result<Self> {
        let place = keys.path().to_owned();
        let id = keys.whole("id", 1..=999_999)?;
        let id = keys.needed("id", id, "the model's number, from 1")? as u32;
        let objects = keys.texts("objects")?.map(|names| names.into_iter().map(str::to_owned).collect());
        let objects = keys.needed("objects", objects, "a list of the capture's objects with this mesh")?;
        let mut continuous = Vec::new();
        for mut axis in keys.tables("symmetries_continuous")? {
            let direction = axis.numbers("axis", 3, Range::ANY)?;
            let direction = axis.needed("axis", direction, "a direction: [x, y, z]")?;
            let offset = axis.numbers("offset", 3, Range::ANY)?.unwrap_or_else(|| vec![0.0; 3]);
            let three = |v: &[f64]| [v[0], v[1], v[2]];
            if direction.iter().all(|x| *x == 0.0) {
                return Err(axis.refuse("axis", "is no direction", "write a vector that is not 0"));
            }
            continuous.push((three(&direction), three(&offset)));
            axis.finish()?;
        }
        let mut discrete = Vec::new();
        for mut motion in keys.tables("symmetries_discrete")? {
            let rows = motion.numbers("rotation", 9, Range::ANY)?;
            let rows = motion.needed("rotation", rows, "nine numbers, row by row")?;
            let shift = motion.numbers("translation", 3, Range::ANY)?.unwrap_or_else(|| vec![0.0; 3]);
            let rows: [f64; 9] = std::array::from_fn(|i| rows[i]);
            let pose = Pose::from_rows(&rows, [shift[0], shift[1], shift[2]])
                .ok_or_else(|| motion.refuse("rotation", "is no rotation", "write a rotation matrix row by row"))?;
            discrete.push(pose);
            motion.finish()?;
        }
        keys.finish()?;
        Ok(Self { id, objects, discrete, continuous, place })
    }

    /// This, if `capture` has such objects and they are alike.
    pub(crate) fn resolved(&self, capture: &Capture, file: &str) -> Result<Self> {
        let refuse =
            |problem: String, mend: String| SceneError::new(file, problem, mend).at(format!("{}.objects", self.place));
        let mut mesh = None;
        for name in &self.objects {
            let Some(object) = capture.objects.iter().find(|object| object.name == *name) else {
                let known: Vec<&str> = capture.objects.iter().map(|object| object.name.as_str()).collect();
                return Err(refuse(format!("has \"{name}\""), format!("the objects are: {}", known.join(", "))));
            };
            if *mesh.get_or_insert(&object.mesh) != &object.mesh {
                let mend = "list objects of another mesh as another model".to_owned();
                return Err(refuse(format!("has \"{name}\", whose mesh is another"), mend));
            }
        }
        Ok(self.clone())
    }

    /// The motion of an object's mesh to a photo's camera; `None` where the object is scaled.
    #[must_use]
    pub fn pose(placement: &[[f64; 4]; 4], photo: &Photo) -> Option<Pose> {
        model_to_camera(placement, &photo.camera_to_world)
    }

    /// A capture's camera as BOP has it.
    #[must_use]
    pub fn intrinsics(capture: &Capture, photo: &Photo) -> Intrinsics {
        crate::view::intrinsics(&capture.camera_of(photo))
    }
}
