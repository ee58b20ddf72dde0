//! What really stands before the camera, and what the capture will say about it.

use super::mesh;
use super::random::Random;
use super::vectors::{V, cross, scale, sub, unit};
use gonio_scene::capture::{Camera, Frame, Light, LightKind, Material, Model, Object, Photo, Role, Sensor};
use gonio_scene::{Assets, Capture};
use std::sync::Arc;

/// Name of the part, of its material, and of its mesh's file without the extension.
pub const PART: &str = "part";
/// The photo that is held out.
pub const HELD_OUT: usize = 3;
/// Middle of the part, at which every camera looks, metres.
pub const MIDDLE: V = [0.0, 0.0, 0.02];
/// Elevations of the cameras, degrees.
const ELEVATIONS: [f64; 6] = [58.0, 34.0, 72.0, 46.0, 30.0, 50.0];

/// A capture at its true numbers with its meshes and maps.
#[derive(Clone)]
pub struct World {
    pub capture: Capture,
    pub assets: Assets,
}

impl World {
    /// The world of a seed, without any effect: a plastic part on a white board, a lamp beside the camera.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut random = Random::new(seed, 1);
        let colour = [[0.38, 0.55], [0.22, 0.36], [0.10, 0.22]].map(|[low, high]| random.between(low, high));
        let plastic = Model::Plastic {
            base_color: colour,
            roughness: random.between(0.34, 0.46),
            ior: random.between(1.44, 1.58),
            energy_compensation: false,
        };
        let material = |name: &str, model| Material { name: name.to_owned(), model, ..Material::default() };
        let object = |name: &str| Object {
            name: name.to_owned(),
            mesh: format!("{name}.ply"),
            material: name.to_owned(),
            ..Object::default()
        };
        let lamp = Light {
            name: "led".to_owned(),
            frame: Frame::Camera,
            kind: LightKind::Point {
                position: [random.between(0.05, 0.07), random.between(-0.02, 0.01), 0.0],
                intensity: [0.19; 3],
            },
            ..Light::default()
        };
        let turn = random.between(0.0, 6.0);
        let photos = ELEVATIONS.iter().enumerate().map(|(i, elevation)| {
            let azimuth = turn + 2.4 * i as f64 + random.between(-0.2, 0.2);
            let height = (elevation + random.between(-3.0, 3.0)).to_radians();
            let flat = libm::cos(height);
            let away = [flat * libm::cos(azimuth), flat * libm::sin(azimuth), libm::sin(height)];
            Photo {
                file: format!("photos/{i:02}.exr"),
                exposure: 1.3,
                camera_to_world: look(away, 0.33 + random.between(-0.015, 0.015)),
                role: if i == HELD_OUT { Role::HeldOut } else { Role::Fit },
                ..Photo::default()
            }
        });
        let photos = photos.collect();
        let capture = Capture {
            name: "hidden".to_owned(),
            camera: Camera { width: 64, height: 48, fx: 121.0, fy: 121.0, cx: 32.0, cy: 24.0, ..Camera::default() },
            sensor: Sensor { read_noise: 0.003, shot_noise: 0.0003, ..Sensor::default() },
            materials: vec![material(PART, plastic), material("board", Model::Lambert { base_color: [0.8; 3] })],
            objects: vec![object(PART), object("board")],
            lights: vec![lamp],
            photos,
            ..Capture::default()
        };
        let mut world = Self { capture, assets: Assets::default() };
        world.put(PART, mesh::part());
        world.put("board", mesh::cuboid([-0.4, -0.4, -0.01], [0.4, 0.4, 0.0]));
        world
    }

    /// Gives an object its mesh.
    pub fn put(&mut self, name: &str, mesh: gonio_scene::mesh::Mesh) {
        self.assets.meshes.insert(format!("{name}.ply"), Arc::new(mesh));
    }

    /// Adds a box of a matt colour.
    pub fn put_box(&mut self, name: &str, low: V, high: V, base_color: V) {
        self.put(name, mesh::cuboid(low, high));
        let (name, model) = (name.to_owned(), Model::Lambert { base_color });
        self.capture.materials.push(Material { name: name.clone(), model, ..Material::default() });
        self.capture.objects.push(Object {
            mesh: format!("{name}.ply"),
            material: name.clone(),
            name,
            ..Object::default()
        });
    }

    /// The same with another part.
    #[must_use]
    pub fn with_part(&self, mesh: gonio_scene::mesh::Mesh) -> Self {
        let mut other = self.clone();
        other.put(PART, mesh);
        other
    }

    /// The same with a part of another material.
    #[must_use]
    pub fn with_model(&self, model: Model) -> Self {
        let mut other = self.clone();
        other.capture.materials[0].model = model;
        other
    }

    /// The same with a part of another colour.
    #[must_use]
    pub fn with_colour(&self, colour: V) -> Self {
        let Model::Plastic { roughness, ior, .. } = self.plastic() else { unreachable!() };
        self.with_model(Model::Plastic { base_color: colour, roughness, ior, energy_compensation: false })
    }

    /// The same with a part of another roughness.
    #[must_use]
    pub fn with_roughness(&self, roughness: f64) -> Self {
        let Model::Plastic { base_color, ior, .. } = self.plastic() else { unreachable!() };
        self.with_model(Model::Plastic { base_color, roughness, ior, energy_compensation: false })
    }

    /// The part's material.
    #[must_use]
    pub fn plastic(&self) -> Model {
        self.capture.materials[0].model.clone()
    }

    /// Colour and roughness of the part.
    #[must_use]
    pub fn colour_and_roughness(&self) -> (V, f64) {
        match self.capture.materials[0].model {
            Model::Plastic { base_color, roughness, .. } => (base_color, roughness),
            _ => unreachable!(),
        }
    }

    /// Where the lamp is, in the camera's frame.
    pub fn lamp(&mut self) -> &mut V {
        match &mut self.capture.lights[0].kind {
            LightKind::Point { position, .. } => position,
            _ => unreachable!(),
        }
    }

    /// Where the lamp of a photo is in the world.
    #[must_use]
    pub fn lamp_in_room(&self, photo: usize) -> V {
        let m = &self.capture.photos[photo].camera_to_world;
        let LightKind::Point { position: lamp, .. } = self.capture.lights[0].kind else { unreachable!() };
        [0, 1, 2].map(|i| m[i][3] + (0..3).map(|k| m[i][k] * lamp[k]).sum::<f64>())
    }

    /// What the folder will say: first guesses in place of the numbers that are to be fitted.
    #[must_use]
    pub fn guess(&self) -> Capture {
        let mut capture = self.capture.clone();
        capture.materials[0].model =
            Model::Plastic { base_color: [0.5; 3], roughness: 0.5, ior: 1.5, energy_compensation: false };
        if let LightKind::Point { intensity, .. } = &mut capture.lights[0].kind {
            *intensity = [0.13; 3];
        }
        let names = ["base_color", "roughness", "ior"].map(|key| format!("material.{PART}.{key}"));
        capture.fit.parameters = names.into_iter().chain(["light.led.intensity".to_owned()]).collect();
        capture.fit.gray = vec!["light.led.intensity".to_owned()];
        capture
    }
}

/// The pose of a camera that looks at the part's middle from a direction and a distance.
fn look(away: V, distance: f64) -> [[f64; 4]; 4] {
    let forward = scale(away, -1.0);
    let right = unit(cross(forward, [0.0, 0.0, 1.0]));
    let down = cross(forward, right);
    let eye = sub(MIDDLE, scale(forward, distance));
    let row = |i: usize| [right[i], down[i], forward[i], eye[i]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}
