//! A capture made ready to render: loaded once as a [`Stage`], prepared once per set of numbers.

use crate::camera::PhotoCamera;
use crate::geometry::Geometry;
use crate::light::{EnvironmentMap, PhotoLights};
use crate::planes;
use crate::shader::Shader;
use gonio_scene::capture::{CAPTURE_FILE, LightKind, Material};
use gonio_scene::derivative::{Plan, Plane};
use gonio_scene::{Assets, Capture, Parameter, Result, SceneError};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A loaded capture. Keeps the last geometry and materials, which most evaluations of a fit share.
pub struct Stage {
    capture: Capture,
    assets: Assets,
    maps: BTreeMap<String, Arc<EnvironmentMap>>,
    recent: Mutex<Recent>,
}

/// An object's transform, row-major.
type Pose = [[f64; 4]; 4];

/// What the last preparation built. Held only to look up or replace an entry, never while building.
#[derive(Default)]
struct Recent {
    geometry: Option<(Vec<Pose>, Arc<Geometry>)>,
    shaders: Option<(Vec<Material>, Plan, Arc<[Shader]>)>,
}

/// One set of numbers, ready for any tile of any photo.
pub struct Prepared {
    pub(crate) geometry: Arc<Geometry>,
    pub(crate) shaders: Arc<[Shader]>,
    pub(crate) shader_of: Vec<usize>,
    pub(crate) views: Vec<View>,
    pub(crate) plan: Plan,
    /// For each difference plane: its index, the two scenes, and 1 / (2 step).
    pub(crate) differences: Vec<(usize, [Box<Prepared>; 2], f32)>,
}

/// One photo's camera and lights.
pub(crate) struct View {
    pub(crate) camera: PhotoCamera,
    pub(crate) lights: PhotoLights,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Stage {
    /// A capture and the contents of its meshes and maps.
    #[must_use]
    pub fn new(capture: Capture, assets: Assets) -> Self {
        let maps = assets.maps.iter().map(|(path, map)| (path.clone(), Arc::new(EnvironmentMap::new(map)))).collect();
        Self { capture, assets, maps, recent: Mutex::default() }
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
        let mut prepared = self.build(&capture, &plan)?;
        for (index, plane) in plan.planes.iter().enumerate() {
            if let Plane::Difference { terms, step } = plane {
                let moved = |by: f64| -> Result<Box<Prepared>> {
                    let known = capture.numbers();
                    let values = terms
                        .iter()
                        .map(|t| {
                            let (value, range) = known.get(&t.number).copied().ok_or_else(|| {
                                SceneError::new(CAPTURE_FILE, "is no number of this capture", "name another")
                                    .at(t.number.as_str())
                            })?;
                            let target = value + t.ratio * by;
                            if range.holds(target) {
                                Ok((t.number.clone(), target))
                            } else {
                                Err(SceneError::new(
                                    CAPTURE_FILE,
                                    format!("is {value}, too near its bound for a central difference of {by}"),
                                    "start further inside the bounds",
                                )
                                .at(t.number.as_str()))
                            }
                        })
                        .collect::<Result<Vec<_>>>()?;
                    let mut other = capture.clone();
                    other.set_numbers(&values)?;
                    self.build(&other, &Plan::default()).map(Box::new)
                };
                prepared.differences.push((index, [moved(*step)?, moved(-*step)?], (0.5 / step) as f32));
            }
        }
        prepared.plan = plan;
        Ok(prepared)
    }

    fn build(&self, capture: &Capture, plan: &Plan) -> Result<Prepared> {
        let shader_of = capture
            .objects
            .iter()
            .map(|o| {
                capture.materials.iter().position(|m| m.name == o.material).ok_or_else(|| {
                    SceneError::new(CAPTURE_FILE, "names no material", "name a [[material]]")
                        .at(format!("object.{}.material", o.name))
                })
            })
            .collect::<Result<_>>()?;
        let mut views = Vec::with_capacity(capture.photos.len());
        for photo in &capture.photos {
            let camera = capture.camera_of(photo);
            let lights = PhotoLights::new(&capture.lights, photo, &self.maps, &|light| {
                let key = match &light.kind {
                    LightKind::Point { .. } | LightKind::Sphere { .. } => "intensity",
                    LightKind::Directional { .. } => "irradiance",
                    LightKind::Constant { .. } => "radiance",
                    LightKind::Map { .. } => "scale",
                };
                planes::find(plan, &format!("light.{}.{key}", light.name))
            });
            let (width, height) = (camera.width, camera.height);
            views.push(View { camera: PhotoCamera::new(&camera, photo)?, lights, width, height });
        }
        Ok(Prepared {
            geometry: self.geometry(capture)?,
            shaders: self.shaders(capture, plan)?,
            shader_of,
            views,
            plan: plan.clone(),
            differences: Vec::new(),
        })
    }

    fn geometry(&self, capture: &Capture) -> Result<Arc<Geometry>> {
        let key: Vec<_> = capture.objects.iter().map(|o| o.object_to_world).collect();
        // A poisoned lock only means that another preparation panicked while looking up: the entries are whole.
        let recent = || self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((known, geometry)) = &recent().geometry
            && *known == key
        {
            return Ok(geometry.clone());
        }
        let geometry = Arc::new(Geometry::new(capture, &self.assets)?);
        let mut recent = recent();
        // Poses of a central difference come once; the first geometry is the one that returns.
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
