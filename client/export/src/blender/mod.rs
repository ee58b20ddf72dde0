//! Blender 4 and 5: `scene.py`, which builds and renders a photo's scene by Cycles, and its data, `scene.json`.

mod material;

use crate::Result;
use crate::files::{FileMap, pretty};
use crate::ledger::Ledger;
use crate::matrix::with_z;
use crate::ply::{self, Upwards};
use crate::scene::Scene;
use crate::sky;
use crate::view::{Lamp, Shape, View, for_each_camera};
use gonio_scene::capture::{LightKind, MapRole};
use serde_json::{Map, Value, json};

const SCRIPT: &str = include_str!("scene.py");

/// The script, its data, meshes and maps.
///
/// # Errors
/// A map that cannot be encoded.
pub fn files(scene: &Scene<'_>, ledger: &mut Ledger) -> Result<FileMap> {
    judge(scene, ledger);
    let mut files = sky::files(scene)?;
    files.insert("scene.py".to_owned(), SCRIPT.as_bytes().to_vec());
    let mut objects = Vec::new();
    for (part, surface) in scene.placed() {
        let mesh = format!("meshes/{}.ply", part.stem);
        objects.push(json!({ "name": part.stem, "mesh": mesh, "material": surface, "to_world": part.to_world }));
        let colours = material::values(&scene.surfaces[surface], MapRole::BaseColor);
        files.insert(mesh, ply::write(part, colours.as_ref(), Upwards::Up));
    }
    for surface in &scene.surfaces {
        material::textures(surface, &mut files)?;
    }
    let photos: Map<String, Value> = scene.views.iter().map(|view| (view.name.clone(), photo(scene, view))).collect();
    let materials: Vec<Value> = scene.surfaces.iter().map(material::description).collect();
    let data = json!({ "photos": photos, "objects": objects, "materials": materials });
    files.insert("scene.json".to_owned(), pretty("scene.json", &data)?.into_bytes());
    Ok(files)
}

fn photo(scene: &Scene<'_>, view: &View) -> Value {
    let camera = &view.camera;
    let map = view.map.as_ref().and_then(|sky| {
        let file = &scene.maps.get(&sky.path)?.file;
        Some(json!({ "file": file, "scale": sky.scale, "to_world": sky.to_world }))
    });
    json!({
        "width": camera.width, "height": camera.height, "fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy,
        "aperture_radius": camera.aperture_radius, "focus_distance": camera.focus_distance,
        "camera_to_world": view.pose,
        "lamps": view.lamps.iter().map(lamp).collect::<Vec<_>>(), "constant": view.constant, "map": map,
    })
}

fn lamp(lamp: &Lamp) -> Value {
    match &lamp.shape {
        Shape::Point { position } => json!({ "kind": "point", "position": position, "radius": 0.0, "rgb": lamp.rgb }),
        Shape::Sphere { position, radius } => {
            json!({ "kind": "sphere", "position": position, "radius": radius, "rgb": lamp.rgb })
        }
        Shape::Parallel { direction } => {
            let turn: Vec<Vec<f64>> =
                with_z(direction.map(|x| -x)).iter().take(3).map(|row| row[..3].to_vec()).collect();
            json!({ "kind": "directional", "turn": turn, "rgb": lamp.rgb })
        }
    }
}

fn judge(scene: &Scene<'_>, ledger: &mut Ledger) {
    for surface in &scene.surfaces {
        material::judge(surface, ledger);
    }
    for_each_camera(scene.capture, |name, camera| {
        ledger.exact(name, "the camera's lens, shift and the pixels' aspect");
        for lens in ["aperture_radius", "focus_distance"] {
            ledger.exact(
                &format!("{name}.{lens}"),
                if camera.aperture_radius > 0.0 { "depth of field" } else { "a pinhole" },
            );
        }
        let name = format!("{name}.distortion");
        if camera.distortion == [0.0; 5] {
            ledger.exact(&name, "not there");
        } else {
            ledger.lost(&name, "Blender's perspective camera does not distort");
        }
    });
    for light in &scene.capture.lights {
        let name = format!("light.{}", light.name);
        match light.kind {
            LightKind::Point { .. } => ledger.exact(&name, "a point lamp of 4 pi intensity"),
            LightKind::Sphere { .. } => ledger.exact(&name, "a point lamp of 4 pi intensity and this radius"),
            LightKind::Directional { .. } => ledger.exact(&name, "a sun of angle 0"),
            LightKind::Constant { .. } => ledger.exact(&name, "the world's background"),
            LightKind::Map { .. } => {
                ledger.exact(&name, "the world's environment texture");
            }
        }
        ledger.lose_lobe(light, "a lamp here shines to all sides as brightly as along its axis");
    }
}
