//! A capture made ready to render: loaded once as a [`Stage`], prepared once per set of numbers.

use crate::difference::{Difference, Middle};
use crate::geometry::{Geometry, Place, places};
use crate::light::EnvironmentMap;
use crate::paint;
use crate::planes::Forward;
use crate::reflectance::measured;
use crate::scene::{Loaded, Scene, View, shader_of, without};
use crate::shader::Shader;
use gonio_scene::capture::Material;
use gonio_scene::derivative::{Plan, Plane};
use gonio_scene::{Assets, Capture, Parameter, Result};
use std::sync::{Arc, Mutex, PoisonError};

/// A loaded capture. Keeps the last geometry and materials, which most evaluations of a fit share.
pub struct Stage {
    capture: Capture,
    loaded: Loaded,
    recent: Mutex<Recent>,
}

/// What the last preparation built. Held only to look up or replace an entry, never while building.
#[derive(Default)]
struct Recent {
    geometry: Option<(Vec<Place>, Arc<Geometry>)>,
    shaders: Option<(Vec<Material>, Plan, Arc<[Shader]>)>,
}

/// One set of numbers, ready for any tile of any photo.
pub struct Prepared {
    pub(crate) scene: Scene,
    pub(crate) plan: Plan,
    pub(crate) forward: Forward,
    pub(crate) differences: Vec<Difference>,
}

impl Stage {
    /// A capture and the contents of its meshes and maps.
    #[must_use]
    pub fn new(capture: Capture, assets: Assets) -> Self {
        let maps = assets.maps.iter().map(|(path, map)| (path.clone(), Arc::new(EnvironmentMap::new(map)))).collect();
        let textures = paint::textures(&assets);
        Self { capture, loaded: Loaded { assets, textures, maps }, recent: Mutex::default() }
    }

    /// Makes the scene ready at `numbers` (those that differ from the capture's), with the derivative images that
    /// `columns` need.
    ///
    /// # Errors
    /// Unknown names, values out of range, numbers without a derivative, a distortion that folds the image.
    pub fn prepare(&self, numbers: &[(String, f64)], columns: &[Parameter]) -> Result<Prepared> {
        let plan = Plan::new(&self.capture, columns)?;
        let mut capture = self.capture.clone();
        capture.set_numbers(numbers)?;
        let scene = self.build(&capture, &plan)?;
        let mut differences = Vec::new();
        if plan.planes.iter().any(|plane| matches!(plane, Plane::Difference { .. })) {
            let numbers = capture.numbers();
            let middle = Middle { scene: &scene, capture: &capture, numbers, loaded: &self.loaded };
            for (index, plane) in plan.planes.iter().enumerate() {
                if let Plane::Difference { terms, step } = plane {
                    differences.push(middle.difference(index, terms, *step)?);
                }
            }
        }
        Ok(Prepared { scene, forward: Forward::new(&plan), plan, differences })
    }

    fn build(&self, capture: &Capture, plan: &Plan) -> Result<Scene> {
        let view = |photo| View::new(capture, photo, &self.loaded, plan).map(Arc::new);
        Ok(Scene {
            geometry: self.geometry(capture)?,
            without: without(capture, &self.loaded, None)?,
            shaders: self.shaders(capture, plan)?,
            shader_of: shader_of(capture, &self.loaded.assets)?,
            views: capture.photos.iter().map(view).collect::<Result<_>>()?,
            measured: measured(capture, &self.loaded.assets)?,
        })
    }

    fn geometry(&self, capture: &Capture) -> Result<Arc<Geometry>> {
        let key = places(capture, None);
        // A poisoned lock only means that another preparation panicked while looking up: the entries are whole.
        let recent = || self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((known, geometry)) = &recent().geometry
            && *known == key
        {
            return Ok(geometry.clone());
        }
        let geometry = Arc::new(Geometry::new(capture, &key, &self.loaded)?);
        let mut recent = recent();
        // Poses of a search come once; the first geometry is the one that returns.
        if recent.geometry.is_none() || capture.objects == self.capture.objects {
            recent.geometry = Some((key, geometry.clone()));
        }
        Ok(geometry)
    }

    fn shaders(&self, capture: &Capture, plan: &Plan) -> Result<Arc<[Shader]>> {
        let recent = || self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((materials, known, shaders)) = &recent().shaders
            && *materials == capture.materials
            && known == plan
        {
            return Ok(shaders.clone());
        }
        let shaders: Arc<[Shader]> =
            capture.materials.iter().map(|m| Shader::new(m, plan)).collect::<Result<Vec<_>>>()?.into();
        recent().shaders = Some((capture.materials.clone(), plan.clone(), shaders.clone()));
        Ok(shaders)
    }
}
