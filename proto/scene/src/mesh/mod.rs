//! Triangle meshes, and the readers of the file formats that they come in.

mod check;
mod gltf;
mod look;
mod number;
mod obj;
mod ply;
mod polygon;
mod stl;

pub use look::{Group, Look, Picture, Says, Wrap};
pub use ply::write_ply;

use std::path::Path;

use crate::decoder::shielded;
use crate::error::{Result, SceneError};
use crate::files::Files;

/// A triangle mesh in its object's coordinates, in metres.
///
/// What [`read`] returns is sound: at least one triangle, every index in range, every coordinate finite, every normal
/// of unit length, no triangle without an area.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// One unit normal per vertex, to be interpolated over a triangle; `None` where face normals are to be used.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Three vertex indices per triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// How many triangles of the file had no area, and are not in `triangles`.
    pub degenerate: usize,
}

/// What a format's reader found, not checked yet.
#[derive(Debug, Default)]
struct Surface {
    /// As precise as the file has them: what 32 bits make of them is judged before they are rounded.
    positions: Vec<[f64; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    triangles: Vec<[u32; 3]>,
    /// What the file holds besides, that would change how the part looks, as the end of a sentence about the file.
    remarks: Vec<String>,
    /// How it looks, where that was asked for.
    look: Option<Look>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Ply,
    Obj,
    Stl,
    Gltf,
    Glb,
}

/// Reads the mesh file `path`: PLY, OBJ, STL, glTF or GLB, as both its extension and its first bytes say.
///
/// Polygons become triangles: fans where they are convex, clipped ears where not. Vertices that no triangle with an area
/// uses may be unsound; they are left out then. glTF keeps its own axes (y up): the capture's `object_to_world` turns them.
///
/// # Errors
/// The file cannot be read, is not of its extension's format, is truncated or contradicts itself, uses a feature that is
/// not supported, or holds a mesh that cannot be rendered: empty, an index out of range, a coordinate or normal that is
/// not finite, a zero normal, no triangle with an area, a polygon that crosses itself, an extent that no length in metres
/// explains, or coordinates so far from their origin that 32-bit floats cannot hold the shape.
pub fn read(files: &dyn Files, path: &str) -> Result<Mesh> {
    read_with_remarks(files, path).map(|(mesh, _)| mesh)
}

/// As [`read`], without normals: for those who look at the surface's place alone, whatever normals the file has.
///
/// # Errors
/// As [`read`], except for normals.
pub fn read_shape(files: &dyn Files, path: &str) -> Result<Mesh> {
    let surface = read_surface(files, path, false)?;
    check::finish(path, Surface { normals: None, ..surface }).map(|(mesh, _)| mesh)
}

/// As [`read`], and what the file holds besides that would change how the part looks and is not used (colours, textures,
/// several parts): each the end of a sentence about the file.
///
/// # Errors
/// As [`read`].
pub fn read_with_remarks(files: &dyn Files, path: &str) -> Result<(Mesh, Vec<String>)> {
    let mut surface = read_surface(files, path, false)?;
    let remarks = std::mem::take(&mut surface.remarks);
    Ok((check::finish(path, surface)?.0, remarks))
}

/// As [`read`], and how the surface looks by the file. Vertices are split where texture coordinates are.
///
/// # Errors
/// As [`read`]. Of colours, coordinates and materials what cannot be read at all; the rest is for those who use them.
pub fn read_with_look(files: &dyn Files, path: &str) -> Result<(Mesh, Look)> {
    let (mesh, look) = check::finish(path, read_surface(files, path, true)?)?;
    let mut look = look.unwrap_or_default();
    if look.groups.is_empty() {
        look.groups.push(Group::named(""));
    }
    Ok((mesh, look))
}

fn read_surface(files: &dyn Files, path: &str, look: bool) -> Result<Surface> {
    let format = format_of(path)?;
    let bytes = files.read(path)?;
    check_magic(path, format, &bytes)?;
    shielded(path, || match format {
        Format::Ply => ply::read(path, &bytes, look),
        Format::Obj => obj::read(files, path, &bytes, look),
        Format::Stl => stl::read(path, &bytes),
        Format::Gltf | Format::Glb => gltf::read(files, path, &bytes, look),
    })
}

/// The further files that the mesh file `path` with the content `bytes` needs (a glTF's external buffers), named as
/// [`read`] will ask for them.
///
/// # Errors
/// The extension is not a mesh format's, or the file is a glTF that cannot be parsed.
pub fn dependencies(path: &str, bytes: &[u8]) -> Result<Vec<String>> {
    match format_of(path)? {
        // An OBJ's material library changes no geometry.
        Format::Ply | Format::Obj | Format::Stl => Ok(Vec::new()),
        Format::Gltf | Format::Glb => shielded(path, || gltf::dependencies(path, bytes)),
    }
}

fn format_of(path: &str) -> Result<Format> {
    let extension = Path::new(path).extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str().unwrap_or_default() {
        "ply" => Ok(Format::Ply),
        "obj" => Ok(Format::Obj),
        "stl" => Ok(Format::Stl),
        "gltf" => Ok(Format::Gltf),
        "glb" => Ok(Format::Glb),
        _ => Err(SceneError::new(
            path,
            "has no mesh format's extension",
            "use a PLY, OBJ, STL or glTF file: .ply, .obj, .stl, .gltf, .glb",
        )),
    }
}

/// Refuses a file whose first bytes belong to another format than its extension: a binary STL may begin with anything
/// and an OBJ with any text, so for those two it is only known what they are not.
fn check_magic(path: &str, format: Format, bytes: &[u8]) -> Result<()> {
    if bytes.is_empty() {
        return Err(SceneError::new(path, "is empty", "export the mesh again"));
    }
    let bytes = number::without_mark(bytes);
    let text_start = bytes.iter().find(|byte| !byte.is_ascii_whitespace());
    let found = if bytes.starts_with(b"ply") && bytes.get(3).is_some_and(u8::is_ascii_whitespace) {
        Some(Format::Ply)
    } else if bytes.starts_with(b"glTF") {
        Some(Format::Glb)
    } else if text_start == Some(&b'{') && format != Format::Stl {
        Some(Format::Gltf)
    } else if bytes.get(..6).is_some_and(|word| word.eq_ignore_ascii_case(b"solid ")) && format == Format::Obj {
        Some(Format::Stl)
    } else {
        None
    };
    match found {
        Some(found) if found == format => Ok(()),
        Some(found) => Err(SceneError::new(
            path,
            format!("is a {found:?} file by its first bytes, not what its extension says"),
            "rename it to the extension of its format",
        )),
        None if matches!(format, Format::Obj | Format::Stl) => Ok(()),
        None => Err(SceneError::new(
            path,
            format!("does not begin as a {format:?} file"),
            "export it again, or give it the extension of its format",
        )),
    }
}
