//! The models of a dataset: `models_info.json` and a PLY each, in millimetres.

use super::json::{numbered, read};
use super::unit::metres;
use crate::Pose;
use glam::{DMat3, DVec3};
use gonio_scene::files::Files;
use gonio_scene::mesh::{self, Mesh};
use gonio_scene::{Result, SceneError};
use serde::Deserialize;
use std::collections::BTreeMap;

/// The models by the object's number.
pub type Models = BTreeMap<u32, Model>;

/// Which of a dataset's folders of models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelsFolder {
    /// `models_eval`, uniformly resampled for the errors, or `models` where there is none.
    Evaluation,
    /// `models`, for training and rendering, or `models_eval` where there is none.
    Rendering,
}

/// One object.
#[derive(Debug, Clone)]
pub struct Model {
    /// In metres.
    pub mesh: Mesh,
    /// Largest distance of two vertices, in metres, as the dataset states it.
    pub diameter: f64,
    /// Motions of the model onto itself, in metres, without the identity.
    pub discrete: Vec<Pose>,
    /// Axes (unit vector, a point on it in metres) round which any turn maps the model onto itself.
    pub continuous: Vec<(DVec3, DVec3)>,
}

#[derive(Deserialize)]
struct Info {
    diameter: f64,
    #[serde(default)]
    symmetries_discrete: Vec<[f64; 16]>,
    #[serde(default)]
    symmetries_continuous: Vec<Axis>,
}

#[derive(Deserialize)]
struct Axis {
    axis: [f64; 3],
    offset: [f64; 3],
}

impl Model {
    /// Reads every model that `folder/models_info.json` lists.
    ///
    /// # Errors
    /// A file that is missing or bad, a diameter that is none, or a symmetry that is no rigid motion.
    pub fn read_all(files: &dyn Files, folder: &str) -> Result<Models> {
        let path = format!("{folder}/models_info.json");
        let infos = numbered(&path, read::<BTreeMap<String, Info>>(files, &path)?)?;
        infos.iter().map(|(&id, info)| Ok((id, Self::from_info(files, folder, &path, id, info)?))).collect()
    }

    fn from_info(files: &dyn Files, folder: &str, path: &str, id: u32, info: &Info) -> Result<Self> {
        let refuse = |key: String, problem: &str, mend: &str| SceneError::new(path, problem, mend).at(key);
        if !(info.diameter.is_finite() && info.diameter > 0.0) {
            let mend = "write the largest distance of two vertices in millimetres";
            return Err(refuse(format!("{id}.diameter"), "is no diameter", mend));
        }
        let mut discrete = Vec::new();
        for (index, m) in info.symmetries_discrete.iter().enumerate() {
            let rows = [m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]];
            let pose = Pose::from_rows(&rows, [m[3], m[7], m[11]].map(metres)).ok_or_else(|| {
                let mend = "write a rotation and a translation as a 4x4 matrix, row by row";
                refuse(format!("{id}.symmetries_discrete[{index}]"), "is no rigid motion", mend)
            })?;
            discrete.push(pose);
        }
        let mut continuous = Vec::new();
        for (index, axis) in info.symmetries_continuous.iter().enumerate() {
            let (direction, offset) = (DVec3::from_array(axis.axis), DVec3::from_array(axis.offset.map(metres)));
            let direction = direction.try_normalize().filter(|_| offset.is_finite()).ok_or_else(|| {
                let mend = "write a direction and a point on it";
                refuse(format!("{id}.symmetries_continuous[{index}]"), "is no axis", mend)
            })?;
            continuous.push((direction, offset));
        }
        let mesh = in_metres(mesh::read_shape(files, &format!("{folder}/obj_{id:06}.ply"))?);
        Ok(Self { mesh, diameter: metres(info.diameter), discrete, continuous })
    }

    /// The vertices, in metres.
    pub fn vertices(&self) -> impl Iterator<Item = DVec3> + Clone {
        self.mesh.positions.iter().map(|position| DVec3::from_array(position.map(f64::from)))
    }

    /// Every symmetry, the identity among the discrete ones, with turns round an axis in equal steps. `step` is the largest
    /// way of a vertex from one turn to the next, as a part of the diameter; BOP takes 0.01. As there, each discrete one
    /// is followed by each turn, a full turn is left out, and several axes are not combined.
    #[must_use]
    pub fn symmetries(&self, step: f64) -> Vec<Pose> {
        let steps = (std::f64::consts::PI / step).ceil().max(2.0);
        let mut turns = Vec::new();
        for (axis, offset) in &self.continuous {
            let mut index = 1.0;
            while index < steps {
                let rotation = turn(*axis, index * std::f64::consts::TAU / steps);
                turns.push(Pose { rotation, translation: *offset - rotation * *offset });
                index += 1.0;
            }
        }
        if turns.is_empty() {
            turns.push(Pose::IDENTITY);
        }
        let discrete = std::iter::once(Pose::IDENTITY).chain(self.discrete.iter().copied());
        discrete.flat_map(|first| turns.iter().map(move |turn| turn.after(&first)).collect::<Vec<_>>()).collect()
    }
}

/// Rodrigues' formula, by the same bits everywhere.
fn turn(axis: DVec3, angle: f64) -> DMat3 {
    let (sine, cosine) = libm::sincos(angle);
    let cross = DMat3::from_cols(
        DVec3::new(0.0, axis.z, -axis.y),
        DVec3::new(-axis.z, 0.0, axis.x),
        DVec3::new(axis.y, -axis.x, 0.0),
    );
    DMat3::IDENTITY + cross * sine + cross * cross * (1.0 - cosine)
}

fn in_metres(mut mesh: Mesh) -> Mesh {
    #[allow(clippy::cast_possible_truncation)] // positions are floats in the file, too
    for value in mesh.positions.iter_mut().flatten() {
        *value = metres(f64::from(*value)) as f32;
    }
    mesh
}
