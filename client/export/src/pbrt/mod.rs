//! pbrt-v4: `NAME.pbrt` for every photo, with meshes and maps beside it.

mod light;
mod material;
mod octahedron;

use crate::Result;
use crate::files::FileMap;
use crate::ledger::Ledger;
use crate::matrix::{columns, diagonal, product, rigid_inverse};
use crate::ply::{self, Upwards};
use crate::scene::Scene;
use crate::view::{View, for_each_camera};
use std::fmt::Write;

/// The scenes, their meshes and maps.
///
/// # Errors
/// A map that cannot be encoded.
pub fn files(scene: &Scene<'_>, ledger: &mut Ledger) -> Result<FileMap> {
    for surface in &scene.surfaces {
        material::judge(surface, ledger);
    }
    judge(scene, ledger);
    light::judge(scene, ledger);
    let mut files = light::maps(scene)?;
    for part in &scene.parts {
        files.insert(format!("meshes/{}.ply", part.stem), ply::write(part, None, Upwards::Up));
    }
    for surface in &scene.surfaces {
        material::textures(surface, &mut files)?;
    }
    for view in &scene.views {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = write(scene, view, &mut text);
        files.insert(format!("{}.pbrt", view.stem), text.into_bytes());
    }
    Ok(files)
}

/// Numbers as pbrt's lists have them.
fn list(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

fn write(scene: &Scene<'_>, view: &View, out: &mut String) -> std::fmt::Result {
    let camera = &view.camera;
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    // pbrt's camera looks along +z with x to the right and y up; a transform here leads from the world to the camera.
    let to_camera = product(&diagonal([1.0, -1.0, 1.0]), &rigid_inverse(&view.pose));
    writeln!(out, "# {}, photo {}", scene.capture.name.replace('\n', " "), view.name.replace('\n', " "))?;
    writeln!(out, "ColorSpace \"srgb\"\nTransform [ {} ]", list(&columns(&to_camera)))?;
    // A field of view of 90 degrees makes the window's unit the tangent.
    let window = [
        -camera.cx / camera.fx,
        (width - camera.cx) / camera.fx,
        (camera.cy - height) / camera.fy,
        camera.cy / camera.fy,
    ];
    writeln!(out, "Camera \"perspective\" \"float fov\" [ 90 ] \"float screenwindow\" [ {} ]", list(&window))?;
    if camera.aperture_radius > 0.0 {
        let (radius, distance) = (camera.aperture_radius, camera.focus_distance);
        writeln!(out, "    \"float lensradius\" [ {radius} ] \"float focaldistance\" [ {distance} ]")?;
    }
    writeln!(
        out,
        "Film \"rgb\" \"integer xresolution\" [ {} ] \"integer yresolution\" [ {} ]",
        camera.width, camera.height
    )?;
    writeln!(
        out,
        "    \"string filename\" [ \"{}.exr\" ] \"bool savefp16\" [ false ] \"float maxcomponentvalue\" [ 1e30 ]",
        view.stem
    )?;
    writeln!(out, "    \"string sensor\" [ \"cie1931\" ]")?;
    writeln!(out, "PixelFilter \"box\" \"float xradius\" [ 0.5 ] \"float yradius\" [ 0.5 ]")?;
    writeln!(out, "Sampler \"independent\" \"integer pixelsamples\" [ 256 ]")?;
    writeln!(out, "Integrator \"volpath\" \"integer maxdepth\" [ 64 ]\n\nWorldBegin")?;
    for surface in &scene.surfaces {
        material::write(surface, out)?;
    }
    light::write(scene, view, out)?;
    for (part, surface) in scene.placed() {
        writeln!(out, "AttributeBegin\n    NamedMaterial \"{}\"", scene.surfaces[surface].stem)?;
        writeln!(out, "    ConcatTransform [ {} ]", list(&columns(&part.to_world)))?;
        writeln!(out, "    Shape \"plymesh\" \"string filename\" [ \"meshes/{}.ply\" ]\nAttributeEnd", part.stem)?;
    }
    Ok(())
}

fn judge(scene: &Scene<'_>, ledger: &mut Ledger) {
    for_each_camera(scene.capture, |name, camera| {
        ledger.exact(name, "screenwindow");
        for key in ["aperture_radius", "focus_distance"] {
            let place = if camera.aperture_radius > 0.0 { "lensradius and focaldistance" } else { "a pinhole" };
            ledger.exact(&format!("{name}.{key}"), place);
        }
        if camera.distortion != [0.0; 5] {
            ledger.lost(&format!("{name}.distortion"), "pbrt's perspective camera does not distort");
        }
    });
}
