//! Mitsuba 3: `NAME.xml` for every photo, and `scene.py`, which loads the same scenes as objects from `scenes.json`.

mod camera;
mod light;
mod node;
mod surface;

use crate::Result;
use crate::files::{FileMap, pretty};
use crate::ledger::Ledger;
use crate::part::Part;
use crate::ply::{self, Upwards};
use crate::scene::Scene;
use crate::view::View;
use node::{Node, Value};

const SCRIPT: &str = include_str!("scene.py");

/// The scenes, their meshes and maps.
///
/// # Errors
/// A map that cannot be encoded.
pub fn files(scene: &Scene<'_>, ledger: &mut Ledger) -> Result<FileMap> {
    let mut files = FileMap::from([("scene.py".to_owned(), SCRIPT.as_bytes().to_vec())]);
    let mut materials = Vec::new();
    for surface in &scene.surfaces {
        surface::judge(surface, ledger);
        materials.push(surface::bsdf(surface, &mut files)?.called(&format!("material-{}", surface.stem)));
    }
    for part in &scene.parts {
        files.insert(mesh_file(part), ply::write(part, None, Upwards::Down));
    }
    camera::judge(scene, ledger);
    light::judge(scene, ledger);
    let mut objects = serde_json::Map::new();
    for view in &scene.views {
        let (sky, sky_files) = light::sky(scene, view)?;
        files.extend(sky_files);
        let tree = tree(scene, view, &materials, sky);
        files.insert(format!("{}.xml", view.stem), tree.to_xml().into_bytes());
        objects.insert(view.name.clone(), tree.to_object());
    }
    files.insert("scenes.json".to_owned(), pretty("scenes.json", &objects)?.into_bytes());
    Ok(files)
}

fn mesh_file(part: &Part) -> String {
    format!("meshes/{}.ply", part.stem)
}

/// The scene of one photo.
fn tree(scene: &Scene<'_>, view: &View, materials: &[Node], sky: Option<Node>) -> Node {
    let mut tree = Node::new("scene", "scene");
    let path = Node::new("integrator", "path").with("max_depth", Value::Integer(-1));
    tree = tree.with("integrator", Value::Node(path)).with("sensor", Value::Node(camera::sensor(view)));
    for (surface, material) in scene.surfaces.iter().zip(materials) {
        tree = tree.with(&format!("material-{}", surface.stem), Value::Node(material.clone()));
    }
    for (part, surface) in scene.placed() {
        let shape = Node::new("shape", "ply")
            .with("filename", Value::File(mesh_file(part)))
            .with("face_normals", Value::Switch(part.mesh.normals.is_none()))
            .with("to_world", Value::Matrix(part.to_world))
            .with("bsdf", Value::Reference(format!("material-{}", scene.surfaces[surface].stem)));
        tree = tree.with(&format!("object-{}", part.stem), Value::Node(shape));
    }
    for (number, lamp) in view.lamps.iter().enumerate() {
        tree = tree.with(&format!("lamp-{number}"), Value::Node(light::emitter(lamp)));
    }
    match sky {
        Some(sky) => tree.with("sky", Value::Node(sky)),
        None => tree,
    }
}
