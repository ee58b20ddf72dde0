//! The contents of the files that a capture names: meshes and maps for rendering, photographs for comparing.

use crate::capture::{CAPTURE_FILE, Capture, LightKind, MapRole, Object, Photo, Reflectance, Target};
use crate::files::Files;
use crate::image::{self, Image};
use crate::mesh::{self, Look, Mesh};
use crate::reflectance::{self, Directions};
use crate::surroundings::Surroundings;
use crate::textures::{self, Part, TextureKey, parts, wants_look};
use crate::{Result, SceneError};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Everything that a renderer needs besides the capture itself.
#[derive(Debug, Clone, Default)]
pub struct Assets {
    /// Meshes by the path that the capture gives.
    pub meshes: BTreeMap<String, Arc<Mesh>>,
    /// How meshes look by their files, where a material asks for it, by the same path.
    pub looks: BTreeMap<String, Arc<Look>>,
    /// The textures of materials, linear.
    pub textures: BTreeMap<TextureKey, Arc<Image>>,
    /// Environment maps by the path that the capture gives.
    pub maps: BTreeMap<String, Arc<Image>>,
    /// The direction pairs of measured reflectance by the path that the capture gives; its values are no asset.
    pub directions: BTreeMap<String, Arc<Directions>>,
}

impl Assets {
    /// Reads every mesh, texture and environment map of `capture`, and the direction pairs of its measured reflectance.
    ///
    /// # Errors
    /// A missing or broken file; an environment map with negative values.
    pub fn load(capture: &Capture, files: &dyn Files) -> Result<Self> {
        let mut assets = Self::default();
        assets.load_meshes(capture, files)?;
        for object in &capture.objects {
            assets.load_textures(&assets.parts(capture, object)?, files)?;
        }
        for light in &capture.lights {
            if let LightKind::Map { map, .. } = &light.kind
                && !assets.maps.contains_key(map)
            {
                let image = image::read(files, map)?;
                if let Some(i) = image.pixels.iter().position(|p| p.iter().any(|c| *c < 0.0)) {
                    let (x, y) = (i % image.width as usize, i / image.width as usize);
                    return Err(SceneError::new(
                        map,
                        format!("has negative light at pixel ({x}, {y})"),
                        "clamp it to 0",
                    ));
                }
                assets.maps.insert(map.clone(), Arc::new(image));
            }
        }
        for Reflectance { file, .. } in &capture.reflectance {
            if !assets.directions.contains_key(file) {
                assets.directions.insert(file.clone(), Arc::new(Directions::read(files, file)?));
            }
        }
        Ok(assets)
    }

    fn load_meshes(&mut self, capture: &Capture, files: &dyn Files) -> Result<()> {
        // With a look first: its vertices may be split.
        let (looking, plain): (Vec<_>, Vec<_>) = capture.objects.iter().partition(|o| wants_look(capture, o));
        for object in looking {
            if !self.looks.contains_key(&object.mesh) {
                let (mesh, look) = mesh::read_with_look(files, &object.mesh)?;
                self.meshes.insert(object.mesh.clone(), Arc::new(mesh));
                self.looks.insert(object.mesh.clone(), Arc::new(look));
            }
        }
        for object in plain {
            if !self.meshes.contains_key(&object.mesh) {
                self.meshes.insert(object.mesh.clone(), Arc::new(mesh::read(files, &object.mesh)?));
            }
        }
        Ok(())
    }

    fn load_textures(&mut self, parts: &[Part], files: &dyn Files) -> Result<()> {
        for part in parts {
            for (role, varied) in MapRole::ALL.into_iter().zip(&part.maps) {
                if let Some(texture) = varied.as_ref().and_then(|varied| varied.texture.as_ref())
                    && !self.textures.contains_key(&texture.key)
                {
                    let image = Arc::new(textures::read(files, texture, role)?);
                    self.textures.insert(texture.key.clone(), image);
                }
            }
        }
        Ok(())
    }

    /// The parts of an object of `capture`, whose meshes are loaded.
    ///
    /// # Errors
    /// As [`parts`].
    pub fn parts(&self, capture: &Capture, object: &Object) -> Result<Vec<Part>> {
        let look = self.meshes.get(&object.mesh).zip(self.looks.get(&object.mesh));
        let looked = look.filter(|_| wants_look(capture, object)).map(|(mesh, look)| (&**mesh, &**look));
        parts(capture, object, looked)
    }

    /// The files that [`Assets::load`] opens because a mesh's file names them: material libraries and textures.
    ///
    /// # Errors
    /// A mesh that cannot be read, and what [`parts`] refuses.
    pub fn named_by_meshes(capture: &Capture, files: &dyn Files) -> Result<Vec<String>> {
        let mut assets = Self::default();
        let mut looking = capture.clone();
        looking.objects.retain(|object| wants_look(capture, object));
        assets.load_meshes(&looking, files)?;
        let mut named: Vec<String> = assets.looks.values().flat_map(|look| look.libraries.clone()).collect();
        for object in &looking.objects {
            let parts = assets.parts(capture, object)?;
            let textures = parts.iter().flat_map(|part| part.maps.iter().flatten()).filter_map(|v| v.texture.as_ref());
            named.extend(textures.filter(|t| t.embedded.is_none()).map(|texture| texture.key.place.clone()));
        }
        Ok(named)
    }

    /// The paths that [`Assets::load`] opens, and the photos' and masks' where `photos` is set; sorted, each once.
    #[must_use]
    pub fn paths(capture: &Capture, photos: bool) -> Vec<String> {
        let mut paths: Vec<String> = capture.objects.iter().map(|o| o.mesh.clone()).collect();
        paths.extend(capture.materials.iter().flat_map(|m| m.maps.files().cloned()));
        for light in &capture.lights {
            if let LightKind::Map { map, .. } = &light.kind {
                paths.push(map.clone());
            }
        }
        paths.extend(capture.reflectance.iter().map(|r| r.file.clone()));
        if photos {
            for photo in &capture.photos {
                paths.push(photo.file.clone());
                paths.extend(photo.mask.clone());
            }
        }
        paths.sort();
        paths.dedup();
        paths
    }
}

/// A photo's measured values (or the samples of a reflectance file) and which of its pixels count.
#[derive(Debug, Clone)]
pub struct Photograph {
    /// Values as in the file, after response.
    pub image: Image,
    /// Row-major: inside the mask and not clipped in any channel.
    pub counts: Vec<bool>,
    /// Row-major, per channel: the mean of the pixels around that count, which says how large a pixel's noise is without
    /// knowing it; 0 where a pixel does not count.
    pub surroundings: Vec<[f32; 3]>,
    /// Pixels inside the mask that are clipped.
    pub clipped: usize,
}

impl Photograph {
    /// From values and which of them count, of which `counts` holds as many as the image has pixels.
    #[must_use]
    pub fn new(image: Image, counts: Vec<bool>, clipped: usize) -> Self {
        let surroundings = Surroundings::new(&image, &counts).all();
        Self { image, counts, surroundings, clipped }
    }

    /// Reads what was measured for `target`, and what is around each pixel.
    ///
    /// # Errors
    /// As [`Values::of`].
    pub fn of(capture: &Capture, target: Target<'_>, files: &dyn Files) -> Result<Self> {
        let Values { image, counts, clipped } = Values::of(capture, target, files)?;
        Ok(Self::new(image, counts, clipped))
    }

    /// Reads a photo and its mask, and holds them against the camera and the sensor.
    ///
    /// # Errors
    /// As [`Values::of`].
    pub fn load(capture: &Capture, photo: &Photo, files: &dyn Files) -> Result<Self> {
        Self::of(capture, Target::Photo(photo), files)
    }
}

/// What was measured, as it was read: the part of a [`Photograph`] that all else follows from.
#[derive(Debug, Clone)]
pub struct Values {
    /// Values as in the file, after response.
    pub image: Image,
    /// Row-major: inside the mask and not clipped in any channel.
    pub counts: Vec<bool>,
    /// Pixels inside the mask that are clipped.
    pub clipped: usize,
}

impl Values {
    /// Reads what was measured for `target`: a photo with its mask, or samples of reflectance, which stand in the image
    /// as [`Directions`] says, with the values of [`Reflectance::value`].
    ///
    /// # Errors
    /// A missing or broken file, a size other than the camera's, a mask that leaves nothing, and what [`reflectance::read`] refuses.
    pub fn of(capture: &Capture, target: Target<'_>, files: &dyn Files) -> Result<Self> {
        match target {
            Target::Photo(photo) => Self::load(capture, photo, files),
            Target::Reflectance(reflectance) => {
                let (mut image, counts) = reflectance::read(files, reflectance)?;
                #[allow(clippy::cast_possible_truncation)]
                image.pixels.iter_mut().flatten().for_each(|v| *v = reflectance.value(f64::from(*v)).0 as f32);
                Ok(Self { image, counts, clipped: 0 })
            }
        }
    }

    fn load(capture: &Capture, photo: &Photo, files: &dyn Files) -> Result<Self> {
        let camera = capture.camera_of(photo);
        let key = format!("photo.{}", photo.name());
        let size = |what: &str, path: &str, width: u32, height: u32| {
            if (width, height) == (camera.width, camera.height) {
                return Ok(());
            }
            let problem =
                format!("{what} {path} has {width}x{height} pixels, the camera {}x{}", camera.width, camera.height);
            Err(SceneError::new(CAPTURE_FILE, problem, "give the photo its own camera keys, or the file of that size")
                .at(key.as_str()))
        };
        let (width, height) = image::dimensions(files, &photo.file)?;
        size("photo", &photo.file, width, height)?;
        let (image, alpha) = image::read_with_alpha(files, &photo.file)?;
        let mut mask = match &photo.mask {
            Some(path) => {
                let mask = image::read_mask(files, path)?;
                size("mask", path, mask.width, mask.height)?;
                mask.bits
            }
            None => vec![true; image.pixels.len()],
        };
        // What a photo's alpha cuts away is no measurement.
        mask.iter_mut().zip(alpha.into_iter().flatten()).for_each(|(counts, opaque)| *counts &= opaque);
        let is_clipped = |p: &[f32; 3]| p.iter().any(|c| capture.sensor.is_clipped(f64::from(*c)));
        let clipped = image.pixels.iter().zip(&mask).filter(|(p, m)| **m && is_clipped(p)).count();
        let counts: Vec<bool> = image.pixels.iter().zip(&mask).map(|(p, m)| *m && !is_clipped(p)).collect();
        if !counts.contains(&true) {
            let problem = if clipped > 0 { "has no pixel that is not clipped" } else { "has an empty mask" };
            return Err(
                SceneError::new(&photo.file, problem, "mend the mask or the exposure, or remove the photo").at(key)
            );
        }
        Ok(Self { image, counts, clipped })
    }
}
