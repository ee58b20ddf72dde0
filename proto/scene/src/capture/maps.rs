//! Maps: how a material's numbers vary over a mesh.

use super::material::Model;
use super::visit::Visitor;
use crate::Result;

/// A number of a material that a map may vary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// `base_color`: three channels.
    BaseColor,
    /// `roughness`: the green channel, as in glTF.
    Roughness,
    /// `metallic`: the blue channel, as in glTF.
    Metallic,
}

impl Role {
    /// All of them, in the order of their indices.
    pub const ALL: [Self; 3] = [Self::BaseColor, Self::Roughness, Self::Metallic];

    /// The key of `capture.toml`.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::BaseColor => "base_color_map",
            Self::Roughness => "roughness_map",
            Self::Metallic => "metallic_map",
        }
    }
}

/// Where a map's values come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MapSource {
    /// What the mesh's own file says: its vertex colours, and the texture that it names.
    Mesh,
    /// An image, by the mesh's texture coordinates.
    File(String),
}

/// The word that stands for [`MapSource::Mesh`].
const MESH: &str = "mesh";

/// The maps of a material: factors on its numbers from place to place.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Maps([Option<MapSource>; 3]);

impl Maps {
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(Option::is_none)
    }

    /// The map of one number.
    #[must_use]
    pub fn get(&self, role: Role) -> Option<&MapSource> {
        self.0[role as usize].as_ref()
    }

    /// Puts a map on one number, or takes it away.
    pub fn set(&mut self, role: Role, source: Option<MapSource>) {
        self.0[role as usize] = source;
    }

    /// The images that maps name.
    pub fn files(&self) -> impl Iterator<Item = &String> {
        self.0.iter().flatten().filter_map(|source| match source {
            MapSource::File(path) => Some(path),
            MapSource::Mesh => None,
        })
    }

    /// As [`Maps::files`], to be rewritten.
    pub fn files_mut(&mut self) -> impl Iterator<Item = &mut String> {
        self.0.iter_mut().flatten().filter_map(|source| match source {
            MapSource::File(path) => Some(path),
            MapSource::Mesh => None,
        })
    }

    /// Shows the keys that `model` has to the visitor.
    pub(super) fn describe(&mut self, model: &Model, v: &mut dyn Visitor) -> Result<()> {
        let has = |role: Role| match model {
            Model::Lambert { .. } => role == Role::BaseColor,
            Model::Plastic { .. } => true,
            Model::Conductor { .. } => role == Role::Roughness,
        };
        for role in Role::ALL.into_iter().filter(|role| has(*role)) {
            let mut word = self.get(role).map(|source| match source {
                MapSource::Mesh => MESH.to_owned(),
                MapSource::File(path) => path.clone(),
            });
            v.optional_text(role.key(), &mut word)?;
            self.set(role, word.map(|word| if word == MESH { MapSource::Mesh } else { MapSource::File(word) }));
        }
        Ok(())
    }
}
