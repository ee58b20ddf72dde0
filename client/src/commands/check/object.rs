//! Meshes and where they are.

use super::inside;
use super::placed::{Placed, eye};
use super::vector::{Vector, length, sub};
use super::winding::Winding;
use gonio_scene::capture::Object;
use gonio_scene::files::Files;
use gonio_scene::mesh::{self, Mesh};
use gonio_scene::textures::wants_look;
use gonio_scene::{Assets, Capture, SceneError};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// An object smaller than its distance to the nearest camera over this, or larger than its distance times this, is suspicious.
const DISPROPORTION: f64 = 500.0;
/// Share of the area that must turn to some camera.
const FACING: f64 = 0.02;
/// A closed surface whose normals point inward has -1 here, one that is right +1, an open one about 0.
const INWARD: f64 = -0.3;

/// One object.
#[derive(Debug, Serialize)]
pub(super) struct ObjectSummary {
    pub name: String,
    pub mesh: String,
    pub material: String,
    pub triangles: usize,
    /// Triangles of the file that have no area and were left out.
    pub degenerate: usize,
    /// Whether the file has vertex normals.
    pub normals: bool,
    /// Sides of the bounding box along the world's axes, in metres.
    pub extent: [f64; 3],
    /// Photos that it is in view of, by its vertices.
    pub photos: usize,
}

/// Looks at every mesh, and whether cameras can see it.
pub(super) fn look(
    capture: &Capture,
    files: &dyn Files,
    errors: &mut Vec<SceneError>,
    warnings: &mut Vec<String>,
) -> Vec<ObjectSummary> {
    let mut meshes: BTreeMap<&str, Option<Arc<Mesh>>> = BTreeMap::new();
    let mut summaries = Vec::new();
    let mut seen = vec![false; capture.photos.len()];
    let mut all_read = true;
    for object in &capture.objects {
        let looks = wants_look(capture, object);
        if looks {
            errors.extend(look_at_maps(capture, object, files).err());
        }
        let mesh = meshes.entry(&object.mesh).or_insert_with(|| match mesh::read_with_remarks(files, &object.mesh) {
            Ok((mesh, mut remarks)) => {
                // What the file holds besides its shape is used where a material has maps.
                remarks.retain(|_| !looks);
                warnings.extend(remarks.iter().map(|remark| format!("{}: {remark}", object.mesh)));
                warn_of_winding(&object.mesh, &mesh, warnings);
                Some(Arc::new(mesh))
            }
            Err(error) => {
                errors.push(error);
                None
            }
        });
        let Some(mesh) = mesh else {
            all_read = false;
            continue;
        };
        let placed = Placed::new(object, mesh);
        let summary = summarise(&placed, capture, &mut seen);
        if !capture.photos.is_empty() {
            warn(&placed, capture, &summary, warnings);
        }
        summaries.push(summary);
    }
    if capture.photos.is_empty() {
        // Measured reflectance alone: nothing is seen.
    } else if capture.objects.is_empty() {
        warnings.push("capture.toml: object: there is none, so that nothing but lights can be seen".to_owned());
    } else if all_read {
        for (photo, _) in capture.photos.iter().zip(&seen).filter(|(_, seen)| !**seen) {
            warnings.push(format!(
                "capture.toml: photo.{}.camera_to_world: no object is in view; is it world-to-camera, or of another axis convention?",
                photo.name()
            ));
        }
    }
    summaries
}

/// Reads what the materials' maps need.
fn look_at_maps(capture: &Capture, object: &Object, files: &dyn Files) -> Result<(), SceneError> {
    let (materials, objects) = (capture.materials.clone(), vec![object.clone()]);
    Assets::load(&Capture { materials, objects, ..Capture::default() }, files).map(|_| ())
}

fn summarise(placed: &Placed<'_>, capture: &Capture, seen: &mut [bool]) -> ObjectSummary {
    let (low, high) = placed.bounds();
    let mut photos = 0;
    for (photo, seen) in capture.photos.iter().zip(seen) {
        if placed.is_in_view(capture, photo) {
            *seen = true;
            photos += 1;
        }
    }
    ObjectSummary {
        name: placed.object.name.clone(),
        mesh: placed.object.mesh.clone(),
        material: placed.object.material.clone(),
        triangles: placed.mesh.triangles.len(),
        degenerate: placed.mesh.degenerate,
        normals: placed.mesh.normals.is_some(),
        extent: std::array::from_fn(|i| high[i] - low[i]),
        photos,
    }
}

fn warn_of_winding(file: &str, mesh: &Mesh, warnings: &mut Vec<String>) {
    let Winding { torn, doubled } = Winding::of(mesh);
    if doubled > 0 {
        warnings.push(format!(
            "{file}: {doubled} faces lie on each other, wound both ways, so that it is chance which one is hit: export one \
             side only"
        ));
    }
    if torn > 0 {
        warnings.push(format!(
            "{file}: at {torn} edges one face is wound against the other, and a back is black: make the winding consistent"
        ));
    }
}

fn warn(placed: &Placed<'_>, capture: &Capture, summary: &ObjectSummary, warnings: &mut Vec<String>) {
    let (name, mesh) = (&placed.object.name, &placed.object.mesh);
    if summary.degenerate > 0 {
        warnings.push(format!("{mesh}: {} triangles without an area were left out", summary.degenerate));
    }
    if summary.photos == 0 {
        warnings.push(format!("capture.toml: object.{name}: no photo has it in view; is its pose right?"));
    }
    let (low, high) = placed.bounds();
    let extent = summary.extent.iter().copied().fold(0.0, f64::max);
    let centre: Vector = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
    let nearest = capture.photos.iter().map(|p| length(sub(eye(p), centre))).fold(f64::INFINITY, f64::min);
    if extent * DISPROPORTION < nearest || extent > nearest.max(1e-12) * DISPROPORTION {
        warnings.push(format!(
            "{mesh}: object {name} is {extent:.3e} m large and the nearest camera {nearest:.3e} m away: are both in metres?"
        ));
    }
    if placed.against_vertex_normals() > 0.5 {
        warnings.push(format!(
            "{mesh}: the vertex normals point against the faces' winding: flip one of the two in the file"
        ));
    }
    inside::warn(placed, capture, warnings);
    if placed.is_mirrored() {
        warnings.push(format!(
            "capture.toml: object.{name}.object_to_world: mirrors the mesh: a part's mirror image is another part"
        ));
    }
    if placed.outwardness() < INWARD {
        warnings.push(format!("{mesh}: the faces of object {name} point inward: flip their winding in the file"));
    } else if capture.photos.iter().all(|photo| placed.facing(eye(photo)) < FACING) {
        warnings.push(format!(
            "{mesh}: object {name} turns its back to every camera, and a back is black: flip its winding in the file"
        ));
    }
}
