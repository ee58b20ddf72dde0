//! How a glTF looks: its primitives' materials, vertex colours and texture coordinates.

use std::sync::Arc;

use gltf::Semantic;
use gltf::image::Source;
use gltf::material::Material;
use gltf::mesh::Primitive;
use gltf::texture::{Info, WrappingMode};

use super::super::look::{Group, Look, Picture, Wrap};
use super::{accessor, embedded, external};
use crate::capture::MapRole;
use crate::error::{Result, SceneError};
use crate::image::Curve;

/// Collects the look of primitives, in the order of their triangles and vertices.
#[derive(Default)]
pub(super) struct Looks {
    look: Look,
    /// Index of each group's material in the file; `None` for the default material.
    materials: Vec<Option<usize>>,
}

/// The look of one primitive, by vertex.
pub(super) struct Part {
    group: u32,
    colours: Option<Vec<[f32; 3]>>,
    coordinates: Option<Vec<[f32; 2]>>,
}

impl Looks {
    /// Reads what `primitive` says.
    pub fn read(
        &mut self,
        file: &str,
        primitive: &Primitive<'_>,
        buffers: &[Arc<[u8]>],
        vertices: usize,
    ) -> Result<Part> {
        let material = primitive.material();
        let known = self.materials.iter().position(|index| *index == material.index());
        let group = match known {
            Some(group) => group,
            None => {
                self.materials.push(material.index());
                self.look.groups.push(describe(file, &material, buffers)?);
                self.materials.len() - 1
            }
        };
        let whole = |count: usize, what: &str| {
            let problem = format!("has another number of {what} than of positions");
            let error = SceneError::new(file, problem, "export it again, as GLB or PLY");
            if count == vertices { Ok(()) } else { Err(error) }
        };
        let colours = match primitive.get(&Semantic::Colors(0)) {
            None => None,
            Some(of) => Some(accessor::fractions(file, &of, buffers)?),
        };
        let coordinates = match primitive.get(&Semantic::TexCoords(set(&material))) {
            None => None,
            Some(of) => Some(accessor::fractions(file, &of, buffers)?),
        };
        if let Some(colours) = &colours {
            whole(colours.len(), "colours")?;
            self.look.groups[group].of(MapRole::BaseColor).colours = true;
        }
        if let Some(coordinates) = &coordinates {
            whole(coordinates.len(), "texture coordinates")?;
        }
        let colours = colours.map(|all| all.into_iter().map(|[r, g, b, _]| [r, g, b]).collect());
        let coordinates = coordinates.map(|all| all.into_iter().map(|[u, v, ..]| [u, v]).collect());
        Ok(Part { group: u32::try_from(group).unwrap_or(u32::MAX), colours, coordinates })
    }

    /// Appends a primitive whose vertex k is vertex `vertices[k]` of `part`, to a surface of so many vertices.
    pub fn add(&mut self, part: &Part, triangles: usize, vertices: &[u32], before: usize) {
        let look = &mut self.look;
        look.group_of.extend(std::iter::repeat_n(part.group, triangles));
        // White where a primitive has no colours, nowhere where it has no coordinates.
        append(&mut look.colours, part.colours.as_deref(), [1.0; 3], vertices, before);
        append(&mut look.coordinates, part.coordinates.as_deref(), [f32::NAN; 2], vertices, before);
    }

    /// The vertices so far are taken apart: vertex k is now what vertex `vertices[k]` was.
    pub fn take_apart(&mut self, vertices: &[u32]) {
        let pick = |list: &mut Vec<[f32; 3]>| *list = picked(list, vertices);
        self.look.colours.iter_mut().for_each(pick);
        let pick = |list: &mut Vec<[f32; 2]>| *list = picked(list, vertices);
        self.look.coordinates.iter_mut().for_each(pick);
    }

    pub fn finish(self) -> Look {
        self.look
    }
}

fn picked<T: Copy>(list: &[T], vertices: &[u32]) -> Vec<T> {
    vertices.iter().filter_map(|vertex| list.get(*vertex as usize).copied()).collect()
}

fn append<T: Copy>(into: &mut Option<Vec<T>>, from: Option<&[T]>, absent: T, vertices: &[u32], before: usize) {
    match (into.as_mut(), from) {
        (None, None) => {}
        (Some(into), None) => into.extend(vertices.iter().map(|_| absent)),
        (_, Some(from)) => into.get_or_insert_with(|| vec![absent; before]).extend(picked(from, vertices)),
    }
}

/// The set of texture coordinates that a material uses: that of its colour.
fn set(material: &Material<'_>) -> u32 {
    let of = material.pbr_metallic_roughness();
    let infos = [of.base_color_texture(), of.metallic_roughness_texture()];
    infos.into_iter().flatten().next().map_or(0, |info| info.tex_coord())
}

fn describe(file: &str, material: &Material<'_>, buffers: &[Arc<[u8]>]) -> Result<Group> {
    let mut group = Group::named(material.name().unwrap_or_default());
    let of = material.pbr_metallic_roughness();
    let set = set(material);
    let colour = of.base_color_texture();
    let rough = of.metallic_roughness_texture();
    let [r, g, b, _] = of.base_color_factor();
    for (role, factor, info, curve) in [
        (MapRole::BaseColor, [r, g, b], &colour, Curve::Srgb),
        (MapRole::Roughness, [of.roughness_factor(); 3], &rough, Curve::Linear),
        (MapRole::Metallic, [of.metallic_factor(); 3], &rough, Curve::Linear),
    ] {
        let says = group.of(role);
        says.factor = factor;
        says.picture = info.as_ref().map(|info| picture(file, info, set, curve, buffers)).transpose()?;
    }
    Ok(group)
}

fn picture(file: &str, info: &Info<'_>, set: u32, curve: Curve, buffers: &[Arc<[u8]>]) -> Result<Picture> {
    let texture = info.texture();
    let image = texture.source();
    let own = format!("{file}#images[{}]", image.index());
    let mut refused = None;
    if info.texture_transform().is_some() {
        refused = Some("is shown through a transform (KHR_texture_transform)".to_owned());
    } else if info.tex_coord() != set {
        refused =
            Some(format!("has the texture coordinates {}, and the material's colour has {set}", info.tex_coord()));
    }
    let broken = |problem: String| SceneError::new(file, problem, "export it again, as GLB").at(own.as_str());
    let (place, bytes) = match image.source() {
        Source::View { view, .. } => {
            let buffer = buffers.get(view.buffer().index());
            let end = view.offset().checked_add(view.length());
            let content = buffer.zip(end).and_then(|(buffer, end)| buffer.get(view.offset()..end));
            let content = content.ok_or_else(|| broken("does not lie in its buffer".to_owned()))?;
            (own, Some(Arc::from(content)))
        }
        Source::Uri { uri, .. } => match uri.strip_prefix("data:") {
            Some(data) => {
                let content = embedded(data).map_err(broken)?;
                (own, Some(content))
            }
            None => (external(file, uri)?, None),
        },
    };
    let wrap = |mode: WrappingMode| match mode {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    };
    let sampler = texture.sampler();
    Ok(Picture { place, embedded: bytes, curve, wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())], refused })
}
