//! A photo's camera as a UsdGeom camera.

use super::place;
use crate::ledger::Ledger;
use crate::matrix::{diagonal, product};
use crate::scene::Scene;
use crate::view::{View, for_each_camera};
use std::fmt::Write;

/// Focal length that stands for the photo's, tenths of a scene unit as USD has it: 50 mm were the unit a centimetre. With the
/// apertures in the same unit it cancels out.
const FOCAL: f64 = 50.0;

/// The camera: it looks along -z with y up.
pub fn write(view: &View, name: &str, out: &mut String) -> std::fmt::Result {
    let camera = &view.camera;
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    writeln!(out, "        def Camera \"{name}\" (")?;
    writeln!(out, "            customData = {{\n                int height = {}", camera.height)?;
    writeln!(out, "                int width = {}\n            }}\n        )\n        {{", camera.width)?;
    let mut put = |kind: &str, key: &str, value: f64| writeln!(out, "            {kind} {key} = {value}");
    // A thin lens's f-stop is against the focal length in scene units, FOCAL / 10.
    if camera.aperture_radius > 0.0 {
        put("float", "focalLength", focal(camera.aperture_radius))?;
        put("float", "focusDistance", camera.focus_distance)?;
        put("float", "fStop", focal(camera.aperture_radius) / 10.0 / (2.0 * camera.aperture_radius))?;
    } else {
        put("float", "focalLength", FOCAL)?;
        put("float", "fStop", 0.0)?;
    }
    let unit = if camera.aperture_radius > 0.0 { focal(camera.aperture_radius) } else { FOCAL };
    put("float", "horizontalAperture", unit * width / camera.fx)?;
    put("float", "verticalAperture", unit * height / camera.fy)?;
    put("float", "horizontalApertureOffset", unit * (width / 2.0 - camera.cx) / camera.fx)?;
    put("float", "verticalApertureOffset", unit * (camera.cy - height / 2.0) / camera.fy)?;
    writeln!(out, "            float2 clippingRange = (0.001, 10000)\n            token projection = \"perspective\"")?;
    place(&product(&view.pose, &diagonal([1.0, -1.0, -1.0])), 3, out)?;
    writeln!(out, "        }}")
}

/// The focal length of a lens: any would do, so that its f-stop is a usual number.
fn focal(radius: f64) -> f64 {
    radius * 2.0 * 10.0 * 4.0
}

/// Judges the cameras' numbers.
pub fn judge(scene: &Scene<'_>, ledger: &mut Ledger) {
    for_each_camera(scene.capture, |name, camera| {
        ledger.exact(name, "focal length, apertures and their offsets");
        for lens in ["aperture_radius", "focus_distance"] {
            let place = if camera.aperture_radius > 0.0 { "fStop and focusDistance" } else { "a pinhole" };
            ledger.exact(&format!("{name}.{lens}"), place);
        }
        let name = format!("{name}.distortion");
        if camera.distortion == [0.0; 5] {
            ledger.exact(&name, "not there");
        } else {
            ledger.lost(&name, "UsdGeom's cameras do not distort");
        }
    });
}
