//! What a mesh file says of how its surface looks: colours, texture coordinates, its own materials and their textures.
//!
//! Nothing here is checked before a material asks for it: a mesh with broken colours serves all who do not look at them.

use super::Mesh;
use crate::capture::MapRole;
use crate::error::SceneError;
use crate::image::Curve;
use std::sync::Arc;

/// How a mesh looks by its file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Look {
    /// Linear RGB of each vertex, as far as the file has them.
    pub colours: Option<Vec<[f32; 3]>>,
    /// Texture coordinates of each vertex: u to the right and v down, (0, 0) and (1, 1) the image's corners.
    pub coordinates: Option<Vec<[f32; 2]>>,
    /// The file's own materials; at least one in what [`super::read_with_look`] returns.
    pub groups: Vec<Group>,
    /// By triangle: index of its group. Empty where there is one.
    pub group_of: Vec<u32>,
    /// Files that were read for it besides the mesh: material libraries.
    pub libraries: Vec<String>,
    /// Why the groups' textures and factors are not known, where they are not.
    pub unknown: Option<SceneError>,
}

/// One of a mesh file's own materials.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Its name in the file; empty where it has none.
    pub name: String,
    /// What it says of each of a material's numbers, by [`MapRole`].
    pub says: [Says; 3],
}

/// What a mesh file's material says of a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Says {
    /// The same everywhere; linear, ones where nothing is said.
    pub factor: [f32; 3],
    /// By texture coordinates, times the factor.
    pub picture: Option<Picture>,
    /// Whether vertex colours count, times the others.
    pub colours: bool,
}

/// An image that a mesh file refers to.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Its file, or its place inside of the mesh file.
    pub place: String,
    /// Its bytes, where the mesh file holds them.
    pub embedded: Option<Arc<[u8]>>,
    /// How its values are stored.
    pub curve: Curve,
    /// How it goes on beyond its sides: to the left and right, up and down.
    pub wrap: [Wrap; 2],
    /// Why it cannot be used, where it cannot.
    pub refused: Option<String>,
}

/// How an image goes on beyond its sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// From the other side.
    #[default]
    Repeat,
    /// Every other time mirrored.
    Mirror,
    /// Its last texel for ever.
    Clamp,
}

impl Default for Says {
    fn default() -> Self {
        Self { factor: [1.0; 3], picture: None, colours: false }
    }
}

impl Says {
    /// Whether the file says anything.
    #[must_use]
    pub fn anything(&self) -> bool {
        self.picture.is_some() || self.colours || self.factor != [1.0; 3]
    }
}

impl Group {
    /// A material that says nothing.
    pub(super) fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), says: Default::default() }
    }

    /// What it says of a number.
    #[must_use]
    pub fn says(&self, role: MapRole) -> &Says {
        &self.says[role as usize]
    }

    pub(super) fn of(&mut self, role: MapRole) -> &mut Says {
        &mut self.says[role as usize]
    }
}

impl Look {
    /// The group of a triangle.
    #[must_use]
    pub fn group_of(&self, triangle: usize) -> usize {
        self.group_of.get(triangle).map_or(0, |group| *group as usize)
    }

    /// Keeps what belongs to the triangles and vertices that stay.
    pub(super) fn keep(&mut self, triangles: &[bool], vertices: &[bool]) {
        retain(&mut self.group_of, triangles);
        if let Some(colours) = &mut self.colours {
            retain(colours, vertices);
        }
        if let Some(coordinates) = &mut self.coordinates {
            retain(coordinates, vertices);
        }
    }

    /// The first vertex that a triangle of `group` uses and for which `sound` does not hold.
    pub(crate) fn unsound<T>(
        &self,
        mesh: &Mesh,
        group: usize,
        values: &[T],
        sound: impl Fn(&T) -> bool,
    ) -> Option<usize> {
        let of_group = mesh.triangles.iter().enumerate().filter(|(index, _)| self.group_of(*index) == group);
        let mut vertices = of_group.flat_map(|(_, triangle)| triangle.map(|vertex| vertex as usize));
        vertices.find(|vertex| !values.get(*vertex).is_some_and(&sound))
    }
}

pub(super) fn retain<T>(list: &mut Vec<T>, keep: &[bool]) {
    let mut kept = keep.iter();
    list.retain(|_| kept.next().copied().unwrap_or(true));
}
