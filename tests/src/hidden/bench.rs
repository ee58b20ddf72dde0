//! One world photographed again and again: the same films, other sensor noise each time.

use super::film::Films;
use super::random::Random;
use super::world::World;
use super::{Hidden, meshes, photograph, pixels};

/// A world without any effect, rendered once.
pub struct Bench {
    world: World,
    films: Films,
}

impl Bench {
    /// The world of a seed, its photos `scale` times as wide and high, from films of `samples` per pixel.
    #[must_use]
    pub fn new(seed: u64, scale: u32, samples: u32) -> Self {
        let mut world = World::new(seed);
        let camera = &mut world.capture.camera;
        camera.width *= scale;
        camera.height *= scale;
        for length in [&mut camera.fx, &mut camera.fy, &mut camera.cx, &mut camera.cy] {
            *length *= f64::from(scale);
        }
        let films = Films::of(&world, samples, seed);
        Self { world, films }
    }

    /// The capture of a trial: first guesses in its file, and noise of its own in its photos.
    #[must_use]
    pub fn capture(&self, trial: u64) -> Hidden {
        let photos = pixels::noisy(&self.films, &self.world, &mut Random::new(trial, 4));
        photograph(&photos, &self.world.guess(), meshes(&self.world), self.world.capture.clone())
    }
}
