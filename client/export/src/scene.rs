//! A capture as exporters need it: meshes read and placed, names made safe, photos resolved.

use crate::atlas;
use crate::ledger::Ledger;
use crate::name::Names;
use crate::part::{self, Part};
use crate::sky::Map;
use crate::surface::{self, Surface};
use crate::view::{self, View};
use crate::{Format, Result};
use gonio_scene::capture::{CAPTURE_FILE, Tracing};
use gonio_scene::files::Files;
use gonio_scene::{Assets, Capture, SceneError};
use std::collections::BTreeMap;

/// The scene of all photos.
pub struct Scene<'a> {
    pub capture: &'a Capture,
    /// One per photo, in the capture's order.
    pub views: Vec<View>,
    /// The objects that are there.
    pub parts: Vec<Part>,
    /// In the order of the capture's materials; more than one of a material that varies over parts.
    pub surfaces: Vec<Surface>,
    /// By part: index of its surface.
    of_part: Vec<usize>,
    /// The environment maps by their path in the capture.
    pub maps: BTreeMap<String, Map>,
}

impl<'a> Scene<'a> {
    /// Reads what `capture` names, as `format` needs it: where it has no vertex colours, textures hold them.
    ///
    /// # Errors
    /// No photo or no object; a mesh or map that is missing or broken.
    pub fn of(capture: &'a Capture, files: &dyn Files, format: Format) -> Result<Self> {
        let needed = [("photo", capture.photos.is_empty()), ("object", capture.objects.is_empty())];
        if let Some((key, _)) = needed.into_iter().find(|(_, missing)| *missing) {
            let problem = format!("is missing: there is no [[{key}]], so nothing is seen");
            let mend = format!("add at least one [[{key}]] to export a scene");
            return Err(SceneError::new(CAPTURE_FILE, problem, mend).at(key).into());
        }
        // Directions of measured reflectance are no part of a scene: their files need not be there.
        let seen = Capture { reflectance: Vec::new(), ..capture.clone() };
        let assets = Assets::load(&seen, files)?;
        let mut names = Names::default();
        let mut maps = BTreeMap::new();
        for (path, image) in &assets.maps {
            let name = std::path::Path::new(path).file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let file = format!("maps/{}.exr", names.file(&name));
            maps.insert(path.clone(), Map { file, image: image.clone() });
        }
        let mut parts = part::parts(capture, &assets)?;
        // Mitsuba has them, but not below its roughplastic.
        if matches!(format, Format::Mitsuba | Format::Pbrt) {
            let unwrap = |part: Part| match part.paint.vertices() {
                Some(colours) => atlas::unwrap(part, &colours),
                None => part,
            };
            parts = parts.into_iter().map(unwrap).collect();
        }
        let (surfaces, of_part) = surface::surfaces(capture, &parts)?;
        Ok(Self { capture, views: view::views(capture), parts, surfaces, of_part, maps })
    }

    /// Judges what is the same in all formats.
    pub fn judge(&self, ledger: &mut Ledger) {
        ledger.lost("reflectance", "measured data stay with the capture: no scene holds them");
        if self.capture.tracing == Tracing::default() {
            ledger
                .approximated("tracing.ray_offset", "each renderer has its own distance at which rays leave a surface");
        } else {
            ledger.lost("tracing.ray_offset", "each renderer has its own distance at which rays leave a surface");
        }
        part::judge(self.capture, ledger);
        view::judge(self.capture, ledger);
    }

    /// What holds for the whole export, in sentences.
    pub fn remarks(&self, format: Format) -> Vec<String> {
        let mut remarks = vec![
            "Renders hold radiance in the capture's units; photograph() of sensor.py makes a photo's values of them."
                .to_owned(),
            "Gonio's surfaces are black from behind.".to_owned(),
        ];
        remarks.push(match format {
            Format::Mitsuba => {
                "Indices of refraction are against vacuum, and Mitsuba's outside is air, as in Gonio.".to_owned()
            }
            _ => "Indices of refraction are against vacuum; the outside is taken as vacuum there, in Gonio as air."
                .to_owned(),
        });
        remarks
    }

    /// The parts, each with the index of its surface.
    pub fn placed(&self) -> impl Iterator<Item = (&Part, usize)> {
        self.parts.iter().zip(self.of_part.iter().copied())
    }
}
