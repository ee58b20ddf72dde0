//! What an effect adds to a capture.

use crate::overlay::AddedFile;
use gonio_scene::Capture;
use gonio_scene::capture::LightKind;
use std::sync::Arc;

/// Something that a variant adds to a capture.
#[derive(Debug, Clone)]
pub enum Structure {
    /// A light, at intensity or radiance zero.
    Light(gonio_scene::capture::Light),
    /// An object that is absent (presence 0), its material, and the contents of its mesh file.
    Object(Box<(gonio_scene::capture::Object, gonio_scene::capture::Material)>, &'static [u8]),
    /// A point light becomes a sphere of radius zero.
    PointToSphere(String),
}

impl Structure {
    /// Adds it to a capture, once; returns the file that came with it.
    pub fn add(&self, capture: &mut Capture) -> Option<AddedFile> {
        match self {
            Self::Light(light) => {
                if capture.lights.iter().any(|l| l.name == light.name) {
                    return None;
                }
                capture.lights.push(light.clone());
                // A photo that lists its lights had this one on as well.
                for photo in &mut capture.photos {
                    if let Some(on) = &mut photo.lights {
                        on.push(light.name.clone());
                    }
                }
                None
            }
            Self::Object(added, mesh) => {
                let (object, material) = &**added;
                if !capture.objects.iter().any(|o| o.name == object.name) {
                    capture.objects.push(object.clone());
                    capture.materials.push(material.clone());
                }
                Some((object.mesh.clone(), Arc::from(*mesh)))
            }
            Self::PointToSphere(name) => {
                for light in capture.lights.iter_mut().filter(|l| l.name == *name) {
                    if let LightKind::Point { position, intensity } = light.kind {
                        light.kind = LightKind::Sphere { position, radius: 0.0, intensity };
                    }
                }
                None
            }
        }
    }
}
