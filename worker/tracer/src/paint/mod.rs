//! How materials vary over objects by maps: vertex colours, and textures at the triangles' texture coordinates.

mod mipmap;

pub use mipmap::MipMap;

use crate::geometry::Surface;
use glam::{Vec2, Vec3};
use gonio_scene::capture::{CAPTURE_FILE, MapRole, Object};
use gonio_scene::mesh::{Mesh, Wrap};
use gonio_scene::textures::{Part, TextureKey, Varied};
use gonio_scene::{Assets, Capture, Result, SceneError};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The textures of a capture, ready.
pub type Textures = BTreeMap<TextureKey, Arc<MipMap>>;

/// Ready textures of everything that was loaded.
pub fn textures(assets: &Assets) -> Textures {
    assets.textures.iter().map(|(key, image)| (key.clone(), Arc::new(MipMap::new(image)))).collect()
}

/// What varies over the triangles of an object.
pub struct Paint {
    /// The object's first triangle among all.
    first: u32,
    /// By triangle of the object; empty where no map needs them.
    corners: Vec<Corners>,
}

/// What a triangle's corners have.
struct Corners {
    colours: [Vec3; 3],
    coordinates: [Vec2; 3],
    /// Area in texture coordinates over area in the world, 1 / m^2.
    density: f32,
}

/// Maps of a part, by role.
#[derive(Default)]
pub struct PartMaps([Option<Map>; 3]);

/// A factor on a number of a material.
struct Map {
    factor: Vec3,
    colours: bool,
    texture: Option<(Arc<MipMap>, [Wrap; 2])>,
}

/// Factors on a material's numbers at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    pub base_color: Vec3,
    pub roughness: f32,
    pub metallic: f32,
}

impl Factors {
    /// Nothing varies.
    pub const ONE: Self = Self { base_color: Vec3::ONE, roughness: 1.0, metallic: 1.0 };
}

impl PartMaps {
    /// # Errors
    /// A texture that was not loaded.
    pub fn new(part: &Part, object: &Object, textures: &Textures) -> Result<Self> {
        let map = |varied: &Varied| {
            let find = |key: &TextureKey| {
                let refuse = |problem: String| {
                    SceneError::new(CAPTURE_FILE, problem, "load the capture's assets")
                        .at(format!("object.{}", object.name))
                };
                textures.get(key).cloned().ok_or_else(|| refuse(format!("texture {} was not loaded", key.place)))
            };
            let texture = varied.texture.as_ref().map(|t| Ok((find(&t.key)?, t.wrap))).transpose()?;
            Ok(Map { factor: Vec3::from(varied.factor), colours: varied.colours, texture })
        };
        let mut maps = Self::default();
        for (slot, varied) in maps.0.iter_mut().zip(&part.maps) {
            *slot = varied.as_ref().map(map).transpose()?;
        }
        Ok(maps)
    }

    fn any(&self) -> bool {
        self.0.iter().any(Option::is_some)
    }
}

/// Where an object's parts and paint come from.
pub struct Painter {
    /// By triangle of the mesh: its colours and coordinates.
    look: Option<Arc<gonio_scene::mesh::Look>>,
    paint: Paint,
}

impl Painter {
    /// For an object whose first triangle is `first` among all; nothing is kept where none of its `parts` has a map.
    pub fn new(capture: &Capture, object: &Object, assets: &Assets, parts: &[PartMaps], first: usize) -> Self {
        let wanted = gonio_scene::textures::wants_look(capture, object) && parts.iter().any(PartMaps::any);
        let look = wanted.then(|| assets.looks.get(&object.mesh).cloned()).flatten();
        Self { look, paint: Paint { first: first as u32, corners: Vec::new() } }
    }

    /// Adds triangle `index` of the mesh, whose vertices lie there in the world.
    pub fn add(&mut self, mesh: &Mesh, index: usize, world: &[Vec3; 3]) {
        let Some(look) = &self.look else { return };
        let corners = mesh.triangles[index].map(|vertex| vertex as usize);
        let colour = |vertex: usize| look.colours.as_ref().map_or(Vec3::ONE, |colours| Vec3::from(colours[vertex]));
        let pair = |vertex: usize| look.coordinates.as_ref().map_or(Vec2::ZERO, |pairs| Vec2::from(pairs[vertex]));
        let coordinates = corners.map(pair);
        let [a, b, c] = coordinates;
        let area = (world[1] - world[0]).cross(world[2] - world[0]).length();
        let density = if area > 0.0 { (b - a).perp_dot(c - a).abs() / area } else { 0.0 };
        self.paint.corners.push(Corners { colours: corners.map(colour), coordinates, density });
    }

    pub fn finish(self) -> Option<Paint> {
        (!self.paint.corners.is_empty()).then_some(self.paint)
    }
}

impl Paint {
    /// The factors of a part's maps at a point of the object.
    pub fn at(&self, maps: &PartMaps, surface: &Surface) -> Factors {
        let Some(corners) = self.corners.get((surface.triangle - self.first) as usize) else { return Factors::ONE };
        let [u, v] = surface.barycentric;
        let weights = [1.0 - u - v, u, v];
        let role = |role: MapRole| maps.0[role as usize].as_ref();
        let value = |map: &Map| map.at(corners, weights, surface.footprint);
        Factors {
            base_color: role(MapRole::BaseColor).map_or(Vec3::ONE, value),
            roughness: role(MapRole::Roughness).map_or(1.0, |map| value(map).y),
            metallic: role(MapRole::Metallic).map_or(1.0, |map| value(map).z),
        }
    }
}

impl Map {
    fn at(&self, corners: &Corners, [a, b, c]: [f32; 3], footprint: f32) -> Vec3 {
        let mut value = self.factor;
        if self.colours {
            let [first, second, third] = corners.colours;
            // Barycentric coordinates round to just below 0.
            value *= (first * a + second * b + third * c).max(Vec3::ZERO);
        }
        if let Some((texture, wrap)) = &self.texture {
            let [first, second, third] = corners.coordinates;
            let area = corners.density * footprint * footprint;
            value *= texture.at(first * a + second * b + third * c, *wrap, area);
        }
        value
    }
}
