//! glTF 2.0: text with separate or embedded buffers, and the binary GLB.

mod accessor;
mod look;
mod scene;

use std::borrow::Cow;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::buffer::Source;
use gltf::json::Root;
use gltf::json::validation::Checked;
use gltf::{Document, Glb, Semantic};
use percent_encoding::percent_decode_str;

use super::Surface;
use super::number::without_mark;
use crate::decoder::one_line;
use crate::error::{Result, SceneError};
use crate::files::{Files, beside};

const MEND: &str = "export it again, as GLB or PLY";

/// Reads the triangles of a glTF file's default scene, with the transforms of its nodes.
pub(super) fn read(files: &dyn Files, file: &str, bytes: &[u8], look: bool) -> Result<Surface> {
    let (document, binary) = parse(file, bytes)?;
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let place = format!("buffers[{}]", buffer.index());
        let content: Arc<[u8]> = match buffer.source() {
            Source::Bin => binary
                .as_deref()
                .map(Arc::from)
                .ok_or_else(|| SceneError::new(file, "refers to a binary chunk that is not there", MEND).at(&place))?,
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => embedded(data).map_err(|problem| SceneError::new(file, problem, MEND).at(&place))?,
                None => files.read(&external(file, uri)?)?,
            },
        };
        if content.len() < buffer.length() {
            let problem = format!("has {} bytes of the {} announced", content.len(), buffer.length());
            return Err(SceneError::new(file, problem, "the buffer is truncated: export the mesh again").at(place));
        }
        buffers.push(content);
    }
    scene::surface(file, &document, &buffers, look)
}

/// The files that hold a glTF file's buffers, named as [`read`] asks for them.
pub(super) fn dependencies(file: &str, bytes: &[u8]) -> Result<Vec<String>> {
    let (document, _) = parse(file, bytes)?;
    let uris = document.buffers().filter_map(|buffer| match buffer.source() {
        Source::Uri(uri) if !uri.starts_with("data:") => Some(uri),
        _ => None,
    });
    uris.map(|uri| external(file, uri)).collect()
}

fn parse<'a>(file: &str, bytes: &'a [u8]) -> Result<(Document, Option<Cow<'a, [u8]>>)> {
    let broken = |error: &dyn std::fmt::Display| SceneError::new(file, one_line(error), MEND);
    let (json, binary) = if bytes.starts_with(b"glTF") {
        let length = bytes.get(8..12).and_then(|field| field.try_into().ok()).map_or(0, u32::from_le_bytes);
        if length < 20 || length as usize != bytes.len() {
            let problem = format!("announces {length} bytes and has {}", bytes.len());
            return Err(
                SceneError::new(file, problem, "the file is truncated or damaged: export it again").at("header")
            );
        }
        let glb = Glb::from_slice(bytes).map_err(|error| broken(&error))?;
        (glb.json, glb.bin)
    } else {
        (bytes.into(), None)
    };
    let mut root = Root::from_slice(without_mark(&json)).map_err(|error| broken(&error).at("json"))?;
    // The library knows no extension of these, and would refuse them all.
    root.extensions_required.retain(|extension| !looks_alone(extension));
    if let Some(extension) = root.extensions_required.first() {
        return Err(SceneError::new(
            file,
            format!("needs the extension {extension}, which is not supported"),
            "export without it: without compression, quantization, instances",
        )
        .at("extensionsRequired"));
    }
    check_positions(file, &root)?;
    let document = Document::from_json(root).map_err(|error| match error {
        gltf::Error::Validation(errors) => match errors.first() {
            Some((path, error)) => broken(&format!("is not valid: {error:?}")).at(path.to_string()),
            None => broken(&"is not valid"),
        },
        error => broken(&error),
    })?;
    Ok((document, binary))
}

/// Whether an extension says how a surface looks or is lit, and nothing of where it is.
fn looks_alone(extension: &str) -> bool {
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_", "KHR_xmp"]
        .iter()
        .any(|family| extension.starts_with(family))
}

/// The library's validation looks POSITION accessors up before it has checked that they exist, and would panic.
fn check_positions(file: &str, root: &Root) -> Result<()> {
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut positions =
        primitives.filter_map(|primitive| primitive.attributes.get(&Checked::Valid(Semantic::Positions)));
    match positions.find(|accessor| accessor.value() >= root.accessors.len()) {
        None => Ok(()),
        Some(accessor) => {
            let problem = format!("refers to accessors[{}], which is not there", accessor.value());
            Err(SceneError::new(file, problem, MEND).at("POSITION"))
        }
    }
}

fn embedded(data: &str) -> std::result::Result<Arc<[u8]>, String> {
    let encoded = data
        .split_once(',')
        .and_then(|(kind, encoded)| kind.ends_with(";base64").then_some(encoded))
        .ok_or("has a data URI that is not base64")?;
    STANDARD.decode(encoded).map(Arc::from).map_err(|error| format!("has a damaged data URI: {error}"))
}

fn external(file: &str, uri: &str) -> Result<String> {
    let refused = |problem: &str| {
        Err(SceneError::new(file, format!("{problem}: {uri}"), "keep the file beside the glTF, or use GLB").at("uri"))
    };
    // A colon before any slash makes a scheme: RFC 3986, section 4.2.
    if uri.split('/').next().is_some_and(|segment| segment.contains(':')) {
        return refused("refers to what is no file beside it");
    }
    match percent_decode_str(uri).decode_utf8() {
        Ok(path) if !path.is_empty() => Ok(beside(file, &path)),
        _ => refused("refers to a file by a name that is none"),
    }
}
