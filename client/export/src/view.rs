//! Photos: a camera, the lamps that were on, the sky.

use crate::ledger::Ledger;
use crate::matrix::{Matrix, about_z, diagonal, direction, point, product, rotation, unit};
use crate::name::Names;
use gonio_scene::Capture;
use gonio_scene::capture::{Camera, Frame, Light, LightKind, Photo};

/// What one photo sees.
pub struct View {
    /// The photo's name.
    pub name: String,
    /// A name for files and nodes.
    pub stem: String,
    /// Overrides applied.
    pub camera: Camera,
    /// Maps camera coordinates (x right, y down, z forward) to world coordinates.
    pub pose: Matrix,
    /// The lamps that were on and not dark.
    pub lamps: Vec<Lamp>,
    /// Light from everywhere: the sum over the environments of constant radiance.
    pub constant: [f64; 3],
    /// The map around everything.
    pub map: Option<SkyMap>,
}

/// A lamp in world coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Lamp {
    /// Index of the light in the capture.
    pub light: usize,
    pub shape: Shape,
    /// Intensity (power per solid angle), or irradiance of parallel light; linear RGB.
    pub rgb: [f64; 3],
    /// The exponent of its lobe, and the way it points; exponent 0 shines to all sides.
    pub lobe: (f64, [f64; 3]),
}

/// Where a lamp is.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    Point {
        position: [f64; 3],
    },
    Sphere {
        position: [f64; 3],
        radius: f64,
    },
    /// Parallel light; the unit way that it travels.
    Parallel {
        direction: [f64; 3],
    },
}

/// A map in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyMap {
    /// Its path in the capture.
    pub path: String,
    /// Factor on its values.
    pub scale: f64,
    /// Turns the map's frame (centre column +x, top row +z) to the world's.
    pub to_world: Matrix,
}

impl Lamp {
    /// Radiance of a ball of `radius`: intensity / (pi radius^2).
    pub fn radiance(&self, radius: f64) -> [f64; 3] {
        self.rgb.map(|i| i / (std::f64::consts::PI * radius * radius))
    }
}

/// The photos of a capture.
pub fn views(capture: &Capture) -> Vec<View> {
    let mut names = Names::default();
    capture.photos.iter().map(|photo| view(capture, photo, names.file(photo.name()))).collect()
}

fn view(capture: &Capture, photo: &Photo, stem: String) -> View {
    let mut view = View {
        name: photo.name().to_owned(),
        stem,
        camera: capture.camera_of(photo),
        pose: photo.pose(),
        lamps: Vec::new(),
        constant: [0.0; 3],
        map: None,
    };
    for (index, light) in capture.lights.iter().enumerate() {
        if photo.lights.as_ref().is_some_and(|on| !on.contains(&light.name)) || light.is_dark() {
            continue;
        }
        let frame = frame_of(light, &view.pose);
        match &light.kind {
            LightKind::Constant { radiance } => view.constant.iter_mut().zip(radiance).for_each(|(sum, r)| *sum += r),
            LightKind::Map { map, scale, azimuth } => {
                let to_world = product(&rotation(&frame), &about_z(*azimuth));
                view.map = Some(SkyMap { path: map.clone(), scale: *scale, to_world });
            }
            _ => view.lamps.extend(lamp(light, index, &frame)),
        }
    }
    view
}

/// From the light's frame to the world.
fn frame_of(light: &Light, pose: &Matrix) -> Matrix {
    if light.frame == Frame::Camera { *pose } else { diagonal([1.0; 3]) }
}

/// The lamp that `light` is in its `frame`, which `frame` carries to the world; `None` for an environment.
pub fn lamp(light: &Light, index: usize, frame: &Matrix) -> Option<Lamp> {
    let (shape, rgb) = match &light.kind {
        LightKind::Point { position, intensity } => (Shape::Point { position: point(frame, *position) }, *intensity),
        LightKind::Sphere { position, radius, intensity } if *radius > 0.0 => {
            (Shape::Sphere { position: point(frame, *position), radius: *radius }, *intensity)
        }
        LightKind::Sphere { position, intensity, .. } => {
            (Shape::Point { position: point(frame, *position) }, *intensity)
        }
        LightKind::Directional { direction: way, irradiance } => {
            (Shape::Parallel { direction: unit(direction(frame, *way)) }, *irradiance)
        }
        LightKind::Map { .. } | LightKind::Constant { .. } => return None,
    };
    let lobe = (light.lobe.exponent, unit(direction(frame, light.lobe.axis)));
    Some(Lamp { light: index, shape, rgb, lobe })
}

/// Judges what the sensor function and the lamps of all formats have in common.
pub fn judge(capture: &Capture, ledger: &mut Ledger) {
    for photo in &capture.photos {
        for key in ["camera_to_world", "translation", "rotation"] {
            ledger.exact(&format!("photo.{}.{key}", photo.name()), "the camera's motion");
        }
    }
    for light in &capture.lights {
        let name = format!("light.{}", light.name);
        if light.is_dark() {
            ledger.exact(&name, "dark: left out");
        }
        if light.lobe.exponent == 0.0 {
            ledger.exact(&format!("{name}.lobe_exponent"), "shines to all sides");
            ledger.exact(&format!("{name}.lobe_axis"), "shines to all sides");
        }
    }
}

/// Calls `judge` with the dotted beginning of every camera's keys (`camera`, and `photo.NAME.camera` where a photo has keys of
/// its own) and that camera: the base camera is judged by every photo that uses it.
pub fn for_each_camera(capture: &Capture, mut judge: impl FnMut(&str, &Camera)) {
    for photo in &capture.photos {
        let camera = capture.camera_of(photo);
        judge("camera", &camera);
        judge(&format!("photo.{}.camera", photo.name()), &camera);
    }
}
