//! OpenUSD: `scene.usda`, with a file for every mesh.
//!
//! The stage is in metres with z up. The photo is a variant: it says which lamps shine, and holds those that move with its
//! camera. Cameras of all photos are there.

mod camera;
mod light;
mod material;
mod mesh;
mod text;
mod texture;

use crate::files::FileMap;
use crate::ledger::Ledger;
use crate::matrix::Matrix;
use crate::name::Names;
use crate::scene::Scene;
use crate::sky;
use gonio_scene::capture::MapRole;
use std::fmt::Write;
use text::{matrix, quoted};

/// The file of the stage.
const STAGE: &str = "scene.usda";

/// The stage, meshes and maps.
///
/// # Errors
/// A map that cannot be encoded.
pub fn files(scene: &Scene<'_>, ledger: &mut Ledger) -> crate::Result<FileMap> {
    camera::judge(scene, ledger);
    light::judge(scene, ledger);
    let mut files = sky::files(scene)?;
    for (part, surface) in scene.placed() {
        let colours = texture::values(&scene.surfaces[surface], MapRole::BaseColor);
        files.insert(mesh_file(&part.stem), mesh::file(part, colours.as_ref()).into_bytes());
    }
    for surface in &scene.surfaces {
        texture::files(surface, &mut files)?;
    }
    let mut names = Names::default();
    let materials: Vec<String> = scene.surfaces.iter().map(|surface| names.identifier(&surface.stem)).collect();
    let mut names = Names::default();
    let cameras: Vec<String> = scene.views.iter().map(|view| names.identifier(&view.stem)).collect();

    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write(scene, ledger, &materials, &cameras, &mut out);
    files.insert(STAGE.to_owned(), out.into_bytes());
    Ok(files)
}

fn mesh_file(stem: &str) -> String {
    format!("meshes/{stem}.usda")
}

fn write(
    scene: &Scene<'_>,
    ledger: &mut Ledger,
    materials: &[String],
    cameras: &[String],
    out: &mut String,
) -> std::fmt::Result {
    writeln!(out, "#usda 1.0\n(\n    defaultPrim = \"Scene\"\n    metersPerUnit = 1\n    upAxis = \"Z\"\n)\n")?;
    let first = cameras.first().map_or("", String::as_str);
    writeln!(out, "def Xform \"Scene\" (")?;
    writeln!(out, "    prepend variantSets = \"photo\"\n    variants = {{ string photo = \"{first}\" }}\n)\n{{")?;
    writeln!(out, "    def Scope \"Materials\"\n    {{")?;
    for (surface, name) in scene.surfaces.iter().zip(materials) {
        material::judge(surface, ledger);
        material::write(surface, name, out)?;
    }
    writeln!(out, "    }}\n\n    def Scope \"Objects\"\n    {{")?;
    let mut names = Names::default();
    for (part, surface) in scene.placed() {
        let (name, file) = (names.identifier(&part.stem), mesh_file(&part.stem));
        writeln!(out, "        def Mesh \"{name}\" (")?;
        writeln!(
            out,
            "            prepend references = @./{file}@\n            prepend apiSchemas = [\"MaterialBindingAPI\"]"
        )?;
        writeln!(out, "        )\n        {{")?;
        writeln!(out, "            rel material:binding = </Scene/Materials/{}>", materials[surface])?;
        place(&part.to_world, 3, out)?;
        writeln!(out, "        }}")?;
    }
    writeln!(out, "    }}\n\n    def Scope \"Cameras\"\n    {{")?;
    for (view, name) in scene.views.iter().zip(cameras) {
        camera::write(view, name, out)?;
    }
    writeln!(out, "    }}\n\n    variantSet \"photo\" = {{")?;
    for (view, name) in scene.views.iter().zip(cameras) {
        writeln!(out, "        {} {{\n            def Scope \"Lights\"\n            {{", quoted(name))?;
        light::write(scene, view, out)?;
        writeln!(out, "            }}\n        }}")?;
    }
    writeln!(out, "    }}\n}}")
}

/// The motion of a prim, indented by so many levels.
fn place(to_world: &Matrix, depth: usize, out: &mut String) -> std::fmt::Result {
    let pad = "    ".repeat(depth);
    writeln!(out, "{pad}matrix4d xformOp:transform = {}", matrix(to_world))?;
    writeln!(out, "{pad}uniform token[] xformOpOrder = [\"xformOp:transform\"]")
}
