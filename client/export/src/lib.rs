//! Captures in the words of others: Mitsuba 3, Blender, USD, glTF and pbrt.
//!
//! [`export`] turns a capture into files: the scene, its meshes, a Python function for what the sensor does to light
//! (`sensor.py`), and `export.json`, which says of every number whether it was kept exactly, approximated, and how, or lost, and
//! why. Lengths are metres, light is linear RGB (Rec. 709) in the capture's own units; the world stays right-handed with z up
//! (glTF turns it by a node). Nothing is written to disk here.
//!
//! A plastic's base is lit through its boundary and sees its own light turned back from inside. Mitsuba's `roughplastic` and
//! pbrt's `coateddiffuse` know that; the others do not, and get the colour of
//! [`Exchange::plain_colour`](gonio_tracer::bsdf::Exchange::plain_colour).

mod atlas;
mod blender;
mod error;
mod files;
mod format;
mod gltf;
mod ledger;
mod matrix;
mod mitsuba;
mod name;
mod paint;
mod part;
mod pbrt;
mod ply;
mod scene;
mod sensor;
mod sky;
mod surface;
mod texture;
mod usd;
mod view;

pub use error::{ExportError, Result};
pub use files::{Export, Record};
pub use format::Format;
pub use ledger::{Entry, Kept};

use gonio_scene::Capture;
use gonio_scene::files::Files;
use ledger::Ledger;
use scene::Scene;

/// The file that says what became of every number.
pub const RECORD_FILE: &str = "export.json";

/// `capture`, whose meshes and maps are among `files`, as the files of `format`.
///
/// # Errors
/// A capture without a photo or an object; a mesh or a map that is missing or broken; a number outside of its model's range.
pub fn export(capture: &Capture, files: &dyn Files, format: Format) -> Result<Export> {
    let scene = Scene::of(capture, files, format)?;
    let mut ledger = Ledger::new(capture);
    let mut out = sensor::files(&scene, &mut ledger)?;
    scene.judge(&mut ledger);
    out.extend(match format {
        Format::Mitsuba => mitsuba::files(&scene, &mut ledger)?,
        Format::Blender => blender::files(&scene, &mut ledger)?,
        Format::Usd => usd::files(&scene, &mut ledger)?,
        Format::Gltf => gltf::files(&scene, &mut ledger)?,
        Format::Pbrt => pbrt::files(&scene, &mut ledger)?,
    });
    Export::new(&scene, format, ledger, out)
}
