//! How a PLY looks: vertex colours, texture coordinates of vertices or of faces' corners, and MeshLab's `TextureFile`.

use std::collections::HashMap;

use ply_rs_bw::ply::{Header, PropertyType, ScalarType};

use super::super::look::{Group, Look, Picture, Wrap};
use super::vertex::{COLOURS, COORDINATES, Face, Vertex, WEDGES};
use super::{MEND, Splitter, Surface, corners};
use crate::capture::MapRole;
use crate::error::{Result, SceneError};
use crate::files::beside;
use crate::image::{Curve, linear};

/// How MeshLab names a texture in a comment.
const TEXTURE: &str = "TextureFile";

/// `plain` with its look; its vertices are split where faces' corners have coordinates of their own.
pub(super) fn add(file: &str, header: &Header, vertices: &[Vertex], faces: &[Face], plain: Surface) -> Result<Surface> {
    let mut look =
        Look { colours: colours(file, header, vertices)?, groups: vec![Group::named("")], ..Look::default() };
    let has = |element: &str, names: &[&str]| {
        let properties = header.elements.get(element).map(|element| &element.properties);
        properties.is_some_and(|all| names.iter().all(|name| all.contains_key(*name)))
    };
    let mut surface = plain;
    if has("face", &WEDGES) {
        surface = split(file, faces, surface, &mut look)?;
    } else if COORDINATES.iter().any(|names| has("vertex", names)) {
        look.coordinates = Some(vertices.iter().map(|vertex| coordinates(vertex.coordinates)).collect());
    }
    let picture = picture(file, &header.comments);
    let says = look.groups[0].of(MapRole::BaseColor);
    // A texture that was baked has what the vertices had.
    says.colours = look.colours.is_some() && picture.is_none();
    says.picture = picture;
    surface.look = Some(look);
    Ok(surface)
}

/// v runs up in a PLY, as in an OBJ.
#[allow(clippy::cast_possible_truncation)]
fn coordinates([u, v]: [f64; 2]) -> [f32; 2] {
    [u as f32, (1.0 - v) as f32]
}

/// Integers are sRGB by convention, as scanners and MeshLab write them; floats are linear.
#[allow(clippy::cast_possible_truncation)]
fn colours(file: &str, header: &Header, vertices: &[Vertex]) -> Result<Option<Vec<[f32; 3]>>> {
    let Some(properties) = header.elements.get("vertex").map(|element| &element.properties) else { return Ok(None) };
    let Some(names) = COLOURS.iter().find(|names| names.iter().all(|name| properties.contains_key(*name))) else {
        return Ok(None);
    };
    let largest = match properties.get(names[0]).map(|property| &property.data_type) {
        Some(PropertyType::Scalar(ScalarType::UChar)) => 255.0,
        Some(PropertyType::Scalar(ScalarType::UShort)) => 65535.0,
        Some(PropertyType::Scalar(ScalarType::Float | ScalarType::Double)) => 0.0,
        _ => {
            let problem = "has colours of a type that is not known";
            return Err(SceneError::new(file, problem, "write them as uchar, ushort or float").at(names[0]));
        }
    };
    let value = |value: f64| if largest > 0.0 { linear((value / largest) as f32) } else { value as f32 };
    Ok(Some(vertices.iter().map(|vertex| vertex.colour.map(value)).collect()))
}

/// The one texture that the comments name.
fn picture(file: &str, comments: &[String]) -> Option<Picture> {
    let mut named = comments.iter().filter_map(|comment| {
        let (word, name) = comment.trim().split_once(char::is_whitespace)?;
        (word == TEXTURE).then(|| name.trim())
    });
    let first = named.next()?;
    let refused = named.next().map(|_| "is one of several textures of the mesh".to_owned());
    let wrap = [Wrap::Repeat; 2];
    Some(Picture { place: beside(file, first), embedded: None, curve: Curve::Colour, wrap, refused })
}

/// One vertex for every vertex and pair of coordinates that faces' corners join.
fn split(file: &str, faces: &[Face], plain: Surface, look: &mut Look) -> Result<Surface> {
    let mut known = HashMap::new();
    let (mut old, mut own, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    let mut positions = Vec::new();
    let mut splitter = Splitter::new();
    for (number, face) in faces.iter().enumerate() {
        let refuse = |problem: String| SceneError::new(file, problem, MEND).at(format!("face {number}"));
        let mut renamed = Vec::new();
        for (corner, vertex) in corners(face).map_err(refuse)?.into_iter().enumerate() {
            let position = plain.positions.get(vertex as usize).copied();
            let position = position.ok_or_else(|| refuse(format!("names the vertex {vertex}, which is not there")))?;
            let wedge = |axis: usize| face.wedges.get(2 * corner + axis).copied().unwrap_or(f64::NAN);
            let pair = coordinates([wedge(0), wedge(1)]);
            let next = u32::try_from(old.len()).unwrap_or(u32::MAX);
            renamed.push(*known.entry((vertex, pair.map(f32::to_bits))).or_insert_with(|| {
                old.push(vertex as usize);
                own.push(pair);
                positions.push(position);
                next
            }));
        }
        splitter.split(&positions, &renamed, &mut triangles).map_err(refuse)?;
    }
    look.coordinates = Some(own);
    let colours = look.colours.take();
    look.colours = colours.map(|colours| old.iter().filter_map(|vertex| colours.get(*vertex).copied()).collect());
    let normals = plain.normals.map(|all| old.iter().filter_map(|vertex| all.get(*vertex).copied()).collect());
    Ok(Surface { positions, normals, triangles, ..Surface::default() })
}
