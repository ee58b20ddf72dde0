//! Captures with a hidden effect: small, made from a seed, and by code that shares nothing with the fitting path's way of
//! making the effect. What that path samples inside the renderer is arithmetic on films here, or a mean of films, or
//! another mesh.

mod bench;
mod diffusion;
pub mod film;
mod mesh;
pub mod misstate;
mod optics;
mod pixels;
mod places;
pub mod random;
mod surface;
mod unit;
mod vectors;
mod workshop;
mod world;

pub use bench::Bench;
pub use unit::{Unit, unit};
pub use workshop::{InMemory, diagnosed, named};
pub use world::HELD_OUT;

use film::Films;
use gonio_scene::Capture;
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::files::MemoryFiles;
use gonio_scene::image::{Image, encode_exr};
use gonio_scene::mesh::write_ply;
use random::Random;
use std::path::Path;
use std::sync::Arc;
use world::World;

/// Strength that should be found, and one that is a third of it.
pub const STRENGTHS: [(&str, f64); 2] = [("moderate", 1.0), ("weak", 0.35)];

/// A capture as it would lie in a folder, and what is true of it.
pub struct Hidden {
    pub files: MemoryFiles,
    /// The world's numbers before any effect.
    pub truth: Capture,
}

/// Makes the capture of a seed with these effects (name, strength) hidden in it, from films of `samples` per pixel.
///
/// # Panics
/// A name that is no effect's, two effects that are both mixtures of films.
#[must_use]
pub fn hide(effects: &[(&str, f64)], seed: u64, samples: u32) -> Hidden {
    let mut world = World::new(seed);
    let (said, truth) = (world.guess(), world.capture.clone());
    let files = meshes(&world);
    let mut random = Random::new(seed, 2);
    let left: Vec<_> = effects.iter().filter(|(e, s)| !places::apply(e, *s, &mut world, &mut random)).collect();
    let mut films = None;
    let mut last = Vec::new();
    for (effect, strength) in left {
        let made = optics::films(effect, *strength, &world, samples, seed)
            .or_else(|| surface::films(effect, *strength, &world, samples, seed, &mut random));
        match made {
            Some(made) => assert!(films.replace(made).is_none(), "{effect}: only one effect can be a mixture"),
            None => last.push((effect, strength)),
        }
    }
    let mut films = films.unwrap_or_else(|| Films::of(&world, samples, seed));
    for (effect, strength) in last {
        assert!(pixels::apply(effect, *strength, &world, &mut films, &mut random), "{effect} is no effect");
    }
    let photos = pixels::noisy(&films, &world, &mut Random::new(seed, 3));
    photograph(&photos, &said, files, truth)
}

/// A capture as it is said to be, with these photos beside its other files.
fn photograph(photos: &Films, said: &Capture, mut files: MemoryFiles, truth: Capture) -> Hidden {
    let (width, height) = (said.camera.width, said.camera.height);
    for (photo, values) in said.photos.iter().zip(&photos.0) {
        let image = Image { width, height, pixels: values.iter().map(|v| v.map(|x| x as f32)).collect() };
        files.0.insert(photo.file.clone(), encode_exr(&photo.file, &image).unwrap().into());
    }
    files.0.insert(CAPTURE_FILE.to_owned(), Arc::from(said.to_toml().unwrap().as_bytes()));
    Hidden { files, truth }
}

/// The files of a world's meshes.
fn meshes(world: &World) -> MemoryFiles {
    let mut files = MemoryFiles::default();
    for (path, mesh) in &world.assets.meshes {
        files.0.insert(path.clone(), write_ply(mesh).into());
    }
    files
}

impl Hidden {
    /// The same photographs with a file that is wrong.
    ///
    /// # Panics
    /// A change that the format refuses.
    #[must_use]
    pub fn misstated(mut self, wrong: &misstate::Misstatement) -> Self {
        let mut said = Capture::read(&self.files).unwrap();
        (wrong.apply)(&mut said);
        self.files.0.insert(CAPTURE_FILE.to_owned(), Arc::from(said.to_toml().unwrap().as_bytes()));
        self
    }

    /// The same, whose sensor is said to be less noisy than it is.
    ///
    /// # Panics
    /// A change that the format refuses.
    #[must_use]
    pub fn noisier(mut self, factor: f64) -> Self {
        let mut said = Capture::read(&self.files).unwrap();
        said.sensor.read_noise /= factor;
        said.sensor.shot_noise /= factor * factor;
        self.files.0.insert(CAPTURE_FILE.to_owned(), Arc::from(said.to_toml().unwrap().as_bytes()));
        self
    }

    /// Writes the capture's folder.
    pub fn save(&self, folder: &Path) {
        for (path, bytes) in &self.files.0 {
            let path = folder.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
    }
}
