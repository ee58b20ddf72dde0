//! Which of an object's parts has which material, and how that varies over it: a capture's maps, held against a mesh's look.

use crate::capture::{CAPTURE_FILE, MapRole, MapSource, Object};
use crate::image::{self, Curve, Image};
use crate::mesh::{Group, Look, Mesh, Wrap};
use crate::{Capture, Result, SceneError, files::Files};
use std::sync::Arc;

/// A texture, by where it is and how its values become linear: equal keys, equal images.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct TextureKey {
    /// A file, or a place inside of a mesh file.
    pub place: String,
    /// How its values become linear.
    pub curve: Curve,
}

/// A texture of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Which one.
    pub key: TextureKey,
    /// Its bytes, where the mesh file holds them.
    pub embedded: Option<Arc<[u8]>>,
    /// How it goes on beyond its sides.
    pub wrap: [Wrap; 2],
}

/// A factor on one of a material's numbers: the product of what is there.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// The same everywhere, linear.
    pub factor: [f32; 3],
    /// Whether the mesh's vertex colours count.
    pub colours: bool,
    /// By texture coordinates. Roughness is its green, metallic its blue channel.
    pub texture: Option<Texture>,
}

/// The part of an object that has one of the mesh file's own materials; the whole, where the look is not wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Index of the capture's material.
    pub material: usize,
    /// How its numbers vary, by [`MapRole`].
    pub maps: [Option<Varied>; 3],
}

/// Whether an object needs its mesh's look.
#[must_use]
pub fn wants_look(capture: &Capture, object: &Object) -> bool {
    let mut names = std::iter::once(&object.material).chain(object.materials.values());
    let mapped = |name: &String| capture.materials.iter().any(|m| m.name == *name && !m.maps.is_empty());
    !object.materials.is_empty() || names.any(mapped)
}

/// The parts of an object, one for each group of `look`; one in all without it.
///
/// # Errors
/// A material that is not there; a name among `[object.materials]` that no part of the mesh has; a map for which the mesh
/// has no colours or coordinates, or which its file refers to in a way that is not supported.
pub fn parts(capture: &Capture, object: &Object, looked: Option<(&Mesh, &Look)>) -> Result<Vec<Part>> {
    let refuse = |key: &str, problem: String, mend: &str| {
        SceneError::new(CAPTURE_FILE, problem, mend).at(format!("object.{}.{key}", object.name))
    };
    let material = |name: &str, key: &str| {
        let index = capture.material_index(name);
        index.ok_or_else(|| refuse(key, "names no material".to_owned(), "name a [[material]]"))
    };
    let own = material(&object.material, "material")?;
    let Some((mesh, look)) = looked else { return Ok(vec![Part { material: own, maps: Default::default() }]) };
    if let Some(name) = object.materials.keys().find(|name| look.groups.iter().all(|group| group.name != **name)) {
        let names: Vec<&str> = look.groups.iter().map(|group| group.name.as_str()).filter(|n| !n.is_empty()).collect();
        let mend = match names.as_slice() {
            [] => "remove it: the file names no materials of its own".to_owned(),
            names => format!("the names there are: {}", names.join(", ")),
        };
        let problem = format!("is no material of {}", object.mesh);
        return Err(refuse(&format!("materials.{name}"), problem, &mend));
    }
    let part = |(index, group): (usize, &Group)| {
        let given = object.materials.get(&group.name);
        let material = given.map_or(Ok(own), |name| material(name, &format!("materials.{}", group.name)))?;
        let maps = maps(capture, &object.mesh, material, (mesh, look), index)?;
        Ok(Part { material, maps })
    };
    look.groups.iter().enumerate().map(part).collect()
}

fn maps(
    capture: &Capture,
    file: &str,
    material: usize,
    (mesh, look): (&Mesh, &Look),
    group: usize,
) -> Result<[Option<Varied>; 3]> {
    let material = &capture.materials[material];
    let mut all: [Option<Varied>; 3] = Default::default();
    for (role, varied) in MapRole::ALL.into_iter().zip(&mut all) {
        let Some(source) = material.maps.get(role) else { continue };
        let found = match source {
            MapSource::File(path) => {
                let curve = if role == MapRole::BaseColor { Curve::Colour } else { Curve::Linear };
                let key = TextureKey { place: path.clone(), curve };
                let texture = Texture { key, embedded: None, wrap: [Wrap::Repeat; 2] };
                Varied { factor: [1.0; 3], colours: false, texture: Some(texture) }
            }
            MapSource::Mesh => said(file, look, group, role, &material.name)?,
        };
        check(file, &found, (mesh, look), group, &format!("material.{}.{}", material.name, role.key()))?;
        *varied = Some(found);
    }
    Ok(all)
}

/// What the mesh's own file says.
fn said(file: &str, look: &Look, group: usize, role: MapRole, material: &str) -> Result<Varied> {
    if let Some(error) = &look.unknown {
        return Err(error.clone());
    }
    let key = format!("material.{material}.{}", role.key());
    let says = look.groups[group].says(role);
    if !look.groups.iter().any(|group| group.says(role).anything()) {
        let what = if role == MapRole::BaseColor { "neither colours nor a texture of its own" } else { "no such map" };
        let problem = format!("is \"mesh\", and {file} has {what}");
        let mend = "name an image, remove the key, or export the mesh with its colours";
        return Err(SceneError::new(CAPTURE_FILE, problem, mend).at(key));
    }
    let texture = match &says.picture {
        None => None,
        Some(picture) => {
            if let Some(refused) = &picture.refused {
                let mend = "bake it into one image with one set of coordinates";
                return Err(SceneError::new(file, refused.as_str(), mend).at(picture.place.as_str()));
            }
            let key = TextureKey { place: picture.place.clone(), curve: picture.curve };
            Some(Texture { key, embedded: picture.embedded.clone(), wrap: picture.wrap })
        }
    };
    Ok(Varied { factor: says.factor, colours: says.colours, texture })
}

/// Refuses colours and coordinates that are none.
fn check(file: &str, varied: &Varied, (mesh, look): (&Mesh, &Look), group: usize, key: &str) -> Result<()> {
    let broken = |vertex: usize, problem: String, mend: &str| {
        Err(SceneError::new(file, problem, mend).at(format!("vertex {vertex}")))
    };
    if varied.colours
        && let Some(colours) = &look.colours
        && let Some(vertex) =
            look.unsound(mesh, group, colours, |colour| colour.iter().all(|value| *value >= 0.0 && value.is_finite()))
    {
        let problem = format!("has the colour {:?}, which is no reflectance", colours[vertex]);
        return broken(vertex, problem, "mend the colour, or export the mesh without colours");
    }
    if varied.texture.is_none() {
        return Ok(());
    }
    let Some(coordinates) = &look.coordinates else {
        let problem = format!("needs texture coordinates, which {file} does not have");
        return Err(
            SceneError::new(CAPTURE_FILE, problem, "unwrap the mesh and export it again, or remove the key").at(key)
        );
    };
    let sound = |pair: &[f32; 2]| pair.iter().all(|value| value.abs() <= FARTHEST);
    match look.unsound(mesh, group, coordinates, sound) {
        None => Ok(()),
        Some(vertex) => {
            let problem = format!("has the texture coordinates {:?}", coordinates[vertex]);
            broken(vertex, problem, "unwrap the mesh and export it again")
        }
    }
}

/// Texture coordinates beyond have no digits left for a texel.
const FARTHEST: f32 = 4096.0;

/// Reads the texture of a part, whose `role` says what it may hold.
///
/// # Errors
/// As [`image::read_texture`]; a factor on a roughness or a metallic above 1.
pub fn read(files: &dyn Files, texture: &Texture, role: MapRole) -> Result<Image> {
    let TextureKey { place, curve } = &texture.key;
    let image = match &texture.embedded {
        Some(bytes) => image::decode_texture(place, bytes, *curve)?,
        None => image::read_texture(files, place, *curve)?,
    };
    if role != MapRole::BaseColor && image.pixels.iter().flatten().any(|value| *value > 1.0) {
        let problem = format!("has values above 1, and is a {}", role.key());
        return Err(SceneError::new(place.as_str(), problem, "clamp them: it is a factor from 0 to 1"));
    }
    Ok(image)
}
