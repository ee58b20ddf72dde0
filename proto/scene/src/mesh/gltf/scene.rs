//! The triangles of a glTF scene: its nodes, their transforms, their primitives.

use std::sync::Arc;

use glam::{DMat4, DVec3};
use gltf::mesh::{Mode, Primitive};
use gltf::{Document, Node};

use super::super::Surface;
use super::accessor;
use super::look::Looks;
use crate::error::{Result, SceneError};

/// The most memory, in bytes, that the meshes of a scene may take: many nodes can show one large mesh.
const MAX_BYTES: usize = 1 << 30;

/// The triangles of the default scene (or the only one), in the scene's coordinates.
pub(super) fn surface(file: &str, document: &Document, buffers: &[Arc<[u8]>], look: bool) -> Result<Surface> {
    let mut scenes = document.scenes();
    let scene = match (document.default_scene(), scenes.next(), scenes.next()) {
        (Some(scene), ..) | (None, Some(scene), None) => scene,
        (None, first, _) => {
            let problem = if first.is_some() { "has several scenes and no default" } else { "has no scene" };
            return Err(SceneError::new(file, problem, "export one scene, that shows the mesh").at("scene"));
        }
    };
    let looks = look.then(Looks::default);
    let mut gathered = Gathered { file, buffers, surface: Surface::default(), looks, primitives: 0, coloured: false };
    let mut open: Vec<_> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
    open.reverse();
    let mut visited = 0;
    while let Some((node, parent)) = open.pop() {
        visited += 1;
        // In a tree, every node is met once at most.
        if visited > document.nodes().len() {
            let problem = "has nodes that contain each other or have several parents";
            return Err(SceneError::new(file, problem, "export it again, as GLB or PLY").at("nodes"));
        }
        let local = node.transform().matrix().map(|column| column.map(f64::from));
        let to_scene = parent * DMat4::from_cols_array_2d(&local);
        gathered.add(&node, to_scene)?;
        let children = open.len();
        open.extend(node.children().map(|child| (child, to_scene)));
        open[children..].reverse();
    }
    let Gathered { mut surface, primitives, coloured, looks, .. } = gathered;
    surface.look = looks.map(Looks::finish);
    if primitives > 1 {
        surface.remarks.push(format!("has {primitives} parts, which become one"));
    }
    if coloured {
        surface.remarks.push("has vertex colours, which are not used".to_owned());
    }
    if document.textures().len() > 0 {
        surface.remarks.push("has textures, which are not used".to_owned());
    }
    Ok(surface)
}

struct Gathered<'a> {
    file: &'a str,
    buffers: &'a [Arc<[u8]>],
    surface: Surface,
    /// Where the look is wanted.
    looks: Option<Looks>,
    primitives: usize,
    coloured: bool,
}

impl Gathered<'_> {
    fn add(&mut self, node: &Node<'_>, to_scene: DMat4) -> Result<()> {
        let Some(mesh) = node.mesh() else { return Ok(()) };
        let refuse = |problem: &str, mend: &str| {
            Err(SceneError::new(self.file, problem, mend).at(format!("nodes[{}]", node.index())))
        };
        if node.skin().is_some() {
            return refuse("deforms its mesh by a skin", "export the mesh as it stands, without a skeleton");
        }
        // A negative zero or a not-a-number fails this too.
        let determinant = to_scene.determinant();
        if !(determinant.is_finite() && determinant != 0.0) {
            return refuse("has a transform that flattens its mesh or is not finite", "correct its matrix or scale");
        }
        for primitive in mesh.primitives() {
            let place = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
            self.add_primitive(&primitive, to_scene, determinant < 0.0).map_err(|error| match error.key {
                None => error.at(place),
                Some(ref key) => {
                    let key = format!("{place}.{key}");
                    error.at(key)
                }
            })?;
        }
        Ok(())
    }

    fn add_primitive(&mut self, primitive: &Primitive<'_>, to_scene: DMat4, mirrored: bool) -> Result<()> {
        let refuse = |problem: &str, mend: &str| Err(SceneError::new(self.file, problem, mend));
        if primitive.morph_targets().next().is_some() {
            return refuse("has morph targets", "export the mesh as it stands, without animation");
        }
        let Some(positions) = primitive.get(&gltf::Semantic::Positions) else {
            return refuse("has no POSITION", "export it again, as GLB or PLY");
        };
        let positions = accessor::vectors(self.file, &positions, self.buffers)?;
        let normals = match primitive.get(&gltf::Semantic::Normals) {
            Some(accessor) => Some(accessor::vectors(self.file, &accessor, self.buffers)?),
            None => None,
        };
        let count = u32::try_from(positions.len()).unwrap_or(u32::MAX);
        let indices = match primitive.indices() {
            Some(accessor) => accessor::indices(self.file, &accessor, self.buffers)?,
            None => (0..count).collect(),
        };
        if let Some(index) = indices.iter().find(|&&index| index >= count) {
            let problem = format!("names the vertex {index}, but there are only {count} (counted from 0)");
            return refuse(&problem, "export it again, as GLB or PLY");
        }
        // Edges and points are drawn, and are no surface.
        let Some(mut triangles) = triangles(primitive.mode(), &indices) else { return Ok(()) };
        if normals.as_ref().is_some_and(|normals| normals.len() != positions.len()) {
            return refuse("has another number of normals than of positions", "export it again, as GLB or PLY");
        }
        self.primitives += 1;
        self.coloured |= primitive.attributes().any(|(semantic, _)| matches!(semantic, gltf::Semantic::Colors(_)));
        let look = match &mut self.looks {
            Some(looks) => Some(looks.read(self.file, primitive, self.buffers, positions.len())?),
            None => None,
        };
        let into = &mut self.surface;
        // Without normals, a primitive beside others with has flat ones (glTF 2.0, section 3.7.2.1): three vertices a face.
        let flat = normals.is_none() && into.normals.is_some();
        let flat_before = normals.is_some() && into.normals.is_none() && !into.triangles.is_empty();
        let added = if flat { triangles.len() * 3 } else { positions.len() };
        let before = if flat_before { into.triangles.len() * 3 } else { into.positions.len() };
        let bytes = (before + added) * 36 + (into.triangles.len() + triangles.len()) * 12;
        if bytes > MAX_BYTES {
            let problem = format!("brings the scene to {bytes} bytes, above the limit of {MAX_BYTES}");
            return refuse(&problem, "decimate the mesh or show it fewer times");
        }

        if mirrored {
            // glTF 2.0, section 3.7.4: a negative determinant reverses the winding.
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        let point =
            |position: [f32; 3]| to_scene.transform_point3(DVec3::from_array(position.map(f64::from))).to_array();
        let mut part = Surface {
            positions: positions.into_iter().map(point).collect(),
            normals: normals.map(|normals| transform_normals(normals, to_scene)),
            triangles,
            ..Surface::default()
        };
        let mut vertices: Vec<u32> = (0..count).collect();
        if flat {
            vertices = part.triangles.concat();
            part = flattened(&part);
        }
        if flat_before {
            if let Some(looks) = &mut self.looks {
                looks.take_apart(&into.triangles.concat());
            }
            *into = flattened(into);
        }
        if let (Some(looks), Some(look)) = (&mut self.looks, &look) {
            looks.add(look, part.triangles.len(), &vertices, into.positions.len());
        }
        let base = u32::try_from(into.positions.len()).unwrap_or(u32::MAX);
        into.triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|index| index.saturating_add(base))));
        into.positions.extend(part.positions);
        if let Some(normals) = part.normals {
            into.normals.get_or_insert_default().extend(normals);
        }
        Ok(())
    }
}

/// The same triangles with vertices of their own, which have the face's normal; a face without an area has none.
fn flattened(surface: &Surface) -> Surface {
    let mut flat = Surface::default();
    let mut normals = Vec::with_capacity(surface.triangles.len() * 3);
    for triangle in &surface.triangles {
        let corner = |index: u32| surface.positions.get(index as usize).copied().unwrap_or([f64::NAN; 3]);
        let corners = triangle.map(corner);
        let [a, b, c] = corners.map(DVec3::from_array);
        let normal = (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::ZERO).as_vec3().to_array();
        let base = u32::try_from(flat.positions.len()).unwrap_or(u32::MAX);
        flat.positions.extend(corners);
        flat.triangles.push([0, 1, 2].map(|offset| base.saturating_add(offset)));
        normals.extend([normal; 3]);
    }
    Surface { normals: Some(normals), ..flat }
}

/// Normals go by the inverse transpose. Where the scene only moves a mesh, they keep their bits.
fn transform_normals(normals: Vec<[f32; 3]>, to_scene: DMat4) -> Vec<[f32; 3]> {
    let linear = glam::DMat3::from_mat4(to_scene);
    if linear == glam::DMat3::IDENTITY {
        return normals;
    }
    let inverse_transpose = linear.inverse().transpose();
    let turn = |normal: [f32; 3]| {
        let turned = inverse_transpose * DVec3::from_array(normal.map(f64::from));
        // Unit length here, since the inverse of a small scale may exceed f32; a zero normal stays to be refused.
        turned.try_normalize().unwrap_or(DVec3::ZERO).as_vec3().to_array()
    };
    normals.into_iter().map(turn).collect()
}

/// The triangles of a primitive, `None` for points and lines: glTF 2.0, section 3.7.2.1.
fn triangles(mode: Mode, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    let windows = indices.windows(3).enumerate();
    match mode {
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => None,
        Mode::Triangles => Some(indices.as_chunks().0.to_vec()),
        Mode::TriangleStrip => Some(
            windows
                .filter_map(|(number, corners)| match *corners {
                    [a, b, c] if number % 2 == 0 => Some([a, b, c]),
                    [a, b, c] => Some([a, c, b]),
                    _ => None,
                })
                .collect(),
        ),
        Mode::TriangleFan => {
            let (&hub, rim) = indices.split_first()?;
            Some(rim.windows(2).filter_map(|edge| edge.try_into().ok()).map(|[a, b]: [u32; 2]| [hub, a, b]).collect())
        }
    }
}
