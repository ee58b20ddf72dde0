//! How an OBJ looks: vertex colours, texture coordinates, and what its material library says of each material.

use std::io::Cursor;

use super::super::look::{Group, Look, Picture, Says, Wrap};
use super::lines::Geometry;
use super::without_mark;
use crate::capture::MapRole;
use crate::decoder::one_line;
use crate::error::{Result, SceneError};
use crate::files::{Files, beside};
use crate::image::{Curve, linear};

const MEND: &str = "export the mesh again with its .mtl file beside it";

/// The look of `mesh`, whose triangle k is a part of face `face_of[k]`.
pub(super) fn of(
    files: &dyn Files,
    file: &str,
    geometry: &Geometry<'_>,
    mesh: &tobj::Mesh,
    face_of: &[usize],
) -> Result<Look> {
    let vertices = mesh.positions.len() / 3;
    let mut look = Look::default();
    // v runs up in an OBJ. A vertex without a colour or coordinates where others have them: nobody knows which.
    if !mesh.texcoords.is_empty() {
        check(file, "vt", "texture coordinates", mesh.texcoords.len() / 2, vertices)?;
        #[allow(clippy::cast_possible_truncation)]
        let pair = |&[u, v]: &[f64; 2]| [u as f32, (1.0 - v) as f32];
        look.coordinates = Some(mesh.texcoords.as_chunks().0.iter().map(pair).collect());
    }
    if !mesh.vertex_color.is_empty() {
        check(file, "v", "a colour", mesh.vertex_color.len() / 3, vertices)?;
        // sRGB, as MeshLab and Blender write them.
        #[allow(clippy::cast_possible_truncation)]
        let colour = |rgb: &[f64; 3]| rgb.map(|value| linear(value as f32));
        look.colours = Some(mesh.vertex_color.as_chunks().0.iter().map(colour).collect());
    }
    look.groups = geometry.groups.iter().map(|name| Group::named(String::from_utf8_lossy(name))).collect();
    look.group_of = face_of.iter().map(|face| geometry.group_of.get(*face).copied().unwrap_or(0)).collect();
    for name in &geometry.libraries {
        let path = beside(file, &String::from_utf8_lossy(name));
        match library(files, &path) {
            Ok(materials) => {
                look.libraries.push(path.clone());
                materials.iter().for_each(|material| describe(&mut look.groups, &path, material));
            }
            Err(error) => look.unknown = Some(error),
        }
    }
    let coloured = look.colours.is_some();
    for group in &mut look.groups {
        let says = group.of(MapRole::BaseColor);
        // A texture that was baked has what the vertices had, and their colours are instead of the library's one.
        if coloured && says.picture.is_none() {
            *says = Says { colours: true, ..Says::default() };
        }
    }
    Ok(look)
}

fn check(file: &str, key: &str, what: &str, have: usize, vertices: usize) -> Result<()> {
    if have == vertices {
        return Ok(());
    }
    let problem = format!("has {what} at {have} of {vertices} vertices");
    Err(SceneError::new(file, problem, "export them for every vertex, or for none").at(key))
}

fn library(files: &dyn Files, path: &str) -> Result<Vec<tobj::Material>> {
    let bytes = files.read(path)?;
    let loaded = tobj::load_mtl_buf(&mut Cursor::new(without_mark(&bytes)));
    loaded.map(|(materials, _)| materials).map_err(|error| SceneError::new(path, one_line(&error), MEND))
}

/// What the library `path` says of a material that faces use.
fn describe(groups: &mut [Group], path: &str, material: &tobj::Material) {
    let Some(group) = groups.iter_mut().find(|group| group.name == material.name) else { return };
    let picture = |named: &String, curve: Curve| {
        let wrap = [Wrap::Repeat; 2];
        let refused = named.starts_with('-').then(|| format!("has options that are not supported: {named}"));
        Picture { place: beside(path, &named.replace('\\', "/")), embedded: None, curve, wrap, refused }
    };
    let says = group.of(MapRole::BaseColor);
    says.picture = material.diffuse_texture.as_ref().map(|named| picture(named, Curve::Colour));
    #[allow(clippy::cast_possible_truncation)]
    if let Some(diffuse) = material.diffuse {
        says.factor = diffuse.map(|value| value as f32);
    }
    // The keys of the physically based extension that Blender and others write.
    for (role, factor, map) in [(MapRole::Roughness, "Pr", "map_Pr"), (MapRole::Metallic, "Pm", "map_Pm")] {
        let says = group.of(role);
        says.picture = material.unknown_param.get(map).map(|named| picture(named, Curve::Linear));
        if let Some(value) = material.unknown_param.get(factor).and_then(|value| value.parse().ok()) {
            says.factor = [value; 3];
        }
    }
}
