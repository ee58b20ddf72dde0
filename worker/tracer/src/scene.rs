//! What the rays of one set of numbers meet. Sets that differ in little share the rest.

use crate::camera::PhotoCamera;
use crate::geometry::{Geometry, places};
use crate::light::{EnvironmentMap, PhotoLights};
use crate::paint::Textures;
use crate::planes;
use crate::reflectance::Measured;
use crate::shader::Shader;
use gonio_scene::capture::{Light, LightKind, Photo};
use gonio_scene::derivative::Plan;
use gonio_scene::{Assets, Capture, Result};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Geometry, materials, and each photo's camera and lights.
pub(crate) struct Scene {
    pub(crate) geometry: Arc<Geometry>,
    /// Where an object was there for a part of the exposure: that part, and the geometry without it.
    pub(crate) without: Option<(f32, Arc<Geometry>)>,
    pub(crate) shaders: Arc<[Shader]>,
    /// Index into `shaders` by part of an object.
    pub(crate) shader_of: Arc<[usize]>,
    pub(crate) views: Vec<Arc<View>>,
    /// What stands behind the views, by index.
    pub(crate) measured: Arc<[Measured]>,
}

/// One photo's camera and lights.
pub(crate) struct View {
    pub(crate) camera: PhotoCamera,
    pub(crate) lights: PhotoLights,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// The files of a capture, ready.
pub(crate) struct Loaded {
    pub(crate) assets: Assets,
    pub(crate) textures: Textures,
    pub(crate) maps: BTreeMap<String, Arc<EnvironmentMap>>,
}

/// A scene near another, and what a photo sees of the move.
pub(crate) struct Variant {
    pub(crate) scene: Scene,
    /// By material: whether its numbers differ.
    pub(crate) moved: Vec<bool>,
    /// By photo: whether its radiance can differ at all.
    pub(crate) differs: Vec<bool>,
    /// By photo: whether camera rays hit first what they hit in the other scene.
    pub(crate) same_first_hits: Vec<bool>,
}

impl View {
    pub(crate) fn new(capture: &Capture, photo: &Photo, loaded: &Loaded, plan: &Plan) -> Result<Self> {
        let camera = capture.camera_of(photo);
        let lights = PhotoLights::new(&capture.lights, photo, &loaded.maps, &|light| {
            let key = match &light.kind {
                LightKind::Point { .. } | LightKind::Sphere { .. } => "intensity",
                LightKind::Directional { .. } => "irradiance",
                LightKind::Constant { .. } => "radiance",
                LightKind::Map { .. } => "scale",
            };
            planes::find(plan, &format!("light.{}.{key}", light.name))
        });
        let (width, height) = (camera.width, camera.height);
        Ok(Self { camera: PhotoCamera::new(&camera, photo)?, lights, width, height })
    }
}

/// The shader of each part of each object.
///
/// # Errors
/// As [`gonio_scene::textures::parts`].
pub(crate) fn shader_of(capture: &Capture, assets: &Assets) -> Result<Arc<[usize]>> {
    let mut all = Vec::new();
    for object in &capture.objects {
        all.extend(assets.parts(capture, object)?.into_iter().map(|part| part.material));
    }
    Ok(all.into())
}

impl Scene {
    /// This scene, which is `from`'s, as it is with `to`'s numbers: only what they change is built.
    ///
    /// # Errors
    /// As [`crate::Stage::prepare`].
    pub(crate) fn vary(&self, from: &Capture, to: &Capture, loaded: &Loaded) -> Result<Variant> {
        let (was, is) = (places(from, None), places(to, None));
        let same_places = was == is && from.tracing == to.tracing;
        let geometry = if same_places { self.geometry.clone() } else { Arc::new(Geometry::new(to, &is, loaded)?) };
        let without = without(to, loaded, same_places.then_some((from, self)))?;
        let same_geometry = same_places
            && without.as_ref().map(|(share, _)| share) == self.without.as_ref().map(|(share, _)| share)
            && from.partly_present()? == to.partly_present()?;
        let moved: Vec<bool> = from.materials.iter().zip(&to.materials).map(|(a, b)| a != b).collect();
        let shaders = if moved.contains(&true) {
            let shader = |((material, moved), known): ((_, &bool), &Shader)| {
                if *moved { Shader::new(material, &Plan::default()) } else { Ok(known.clone()) }
            };
            let all = to.materials.iter().zip(&moved).zip(self.shaders.iter()).map(shader);
            all.collect::<Result<Vec<_>>>()?.into()
        } else {
            self.shaders.clone()
        };
        let mut views = Vec::with_capacity(self.views.len());
        let mut same_camera = Vec::with_capacity(self.views.len());
        for ((was, is), known) in from.photos.iter().zip(&to.photos).zip(&self.views) {
            let camera = was.pose() == is.pose() && from.camera_of(was) == to.camera_of(is);
            let pose = was.pose() == is.pose();
            let lights = pose && shining(&from.lights, was).eq(shining(&to.lights, is));
            same_camera.push(camera);
            views.push(if camera && lights {
                known.clone()
            } else {
                Arc::new(View::new(to, is, loaded, &Plan::default())?)
            });
        }
        let everywhere = !same_geometry || self.shader_of.iter().any(|shader| moved[*shader]);
        let differs =
            views.iter().zip(&self.views).map(|(is, was)| everywhere || !Arc::ptr_eq(is, was)).collect::<Vec<_>>();
        let same_first_hits = same_camera.iter().map(|camera| same_geometry && *camera).collect();
        let (shader_of, measured) = (self.shader_of.clone(), self.measured.clone());
        let scene = Self { geometry, without, shaders, shader_of, views, measured };
        Ok(Variant { scene, moved, differs, same_first_hits })
    }
}

/// The share of the exposure of the object that was there for a part of it, if one was, and the geometry without it.
/// `near` is a scene, of another capture, whose objects are where this one's are.
///
/// # Errors
/// As [`Geometry::new`]; two such objects.
pub(crate) fn without(
    capture: &Capture,
    loaded: &Loaded,
    near: Option<(&Capture, &Scene)>,
) -> Result<Option<(f32, Arc<Geometry>)>> {
    let Some(object) = capture.partly_present()? else { return Ok(None) };
    let share = capture.objects[object].presence as f32;
    if let Some((other, scene)) = near
        && other.partly_present()? == Some(object)
        && let Some((_, geometry)) = &scene.without
    {
        return Ok(Some((share, geometry.clone())));
    }
    let geometry = Geometry::new(capture, &places(capture, Some(object)), loaded)?;
    Ok(Some((share, Arc::new(geometry))))
}

/// The lights that shine in a photo.
fn shining<'l>(lights: &'l [Light], photo: &'l Photo) -> impl Iterator<Item = &'l Light> {
    let lit = lights.iter().filter(|light| !light.is_dark());
    lit.filter(|light| photo.lights.as_ref().is_none_or(|on| on.contains(&light.name)))
}
