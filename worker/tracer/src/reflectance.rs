//! Measured reflectance: the BRDF of a material at given pairs of directions, exact, in place of a render.
//!
//! A sample is a pixel (see [`Directions`]). Its radiance is the BRDF in 1/sr, without a cosine; both halves are equal, as
//! no random number enters. A flat sample knows no place: variations over an object and its bumps are left out, and the
//! tangent is azimuth 0.

use crate::difference::Difference;
use crate::prepared::Prepared;
use crate::render::TileTask;
use crate::scene::Variant;
use crate::shader::{MAX_SLOTS, Shader};
use glam::Vec3;
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::film::{FIRST_HIT_CHANNELS, PixelSet, Tile, TileFilm};
use gonio_scene::reflectance::{Directions, Pair};
use gonio_scene::{Assets, Capture, Result, SceneError};
use std::sync::Arc;

/// One file of measured reflectance.
#[derive(Clone)]
pub(crate) struct Measured {
    directions: Arc<Directions>,
    /// Index of its material's shader.
    shader: usize,
}

/// The measured reflectance of a capture, in its order.
///
/// # Errors
/// A material that is not there, directions that were not loaded.
pub(crate) fn measured(capture: &Capture, assets: &Assets) -> Result<Arc<[Measured]>> {
    let of = capture.reflectance.iter().map(|r| {
        let refuse = |problem: &str, mend: &str| {
            SceneError::new(CAPTURE_FILE, problem, mend).at(format!("reflectance.{}", r.name()))
        };
        let shader = capture.materials.iter().position(|m| m.name == r.material);
        let directions = assets.directions.get(&r.file);
        Ok(Measured {
            directions: directions.ok_or_else(|| refuse("was not loaded", "load the capture's assets"))?.clone(),
            shader: shader.ok_or_else(|| refuse("names no material", "name a [[material]]"))?,
        })
    });
    of.collect()
}

impl Measured {
    /// Width and height as a film.
    pub(crate) fn size(&self) -> (u32, u32) {
        self.directions.size()
    }

    /// The pairs of the wanted pixels of a tile; `None` for those past the last sample.
    fn pairs<'a>(&'a self, tile: Tile, pixels: &'a PixelSet) -> impl Iterator<Item = Option<&'a Pair>> {
        pixels.indices().map(move |index| {
            let (x, y) = ((index as u32) % tile.width, (index as u32) / tile.width);
            self.directions.at(tile.x + x, tile.y + y)
        })
    }
}

/// Directions in the shading frame: outgoing, incident.
fn frame(pair: &Pair) -> (Vec3, Vec3) {
    let single = |v: [f64; 3]| Vec3::from(v.map(|c| c as f32));
    (single(pair.outgoing), single(pair.incident))
}

fn brdf(shader: &Shader, wo: Vec3, wi: Vec3) -> Vec3 {
    shader.evaluate(&shader.flat(), wo, wi).value / wi.z
}

impl Prepared {
    /// The film of a tile of measured reflectance, with its derivatives.
    pub(crate) fn reflect(&self, measured: &Measured, task: &TileTask<'_>) -> TileFilm {
        let planes = 1 + self.planes();
        let shader = &self.scene.shaders[measured.shader];
        let local = shader.flat();
        let differences: Vec<_> = self.differences.iter().filter(|d| d.reflects(measured.shader)).collect();
        let mut sums = vec![Vec3::ZERO; planes];
        let mut found = vec![Vec3::ZERO; self.forward.materials];
        let mut half = Vec::with_capacity(2 * 3 * planes * task.pixels.count());
        let (mut pixels, mut invalid_samples) = (0, 0);
        for pair in measured.pairs(task.tile, task.pixels) {
            pixels += 1;
            sums.fill(Vec3::ZERO);
            if let Some(pair) = pair {
                let (wo, wi) = frame(pair);
                let mut slots = [Vec3::ZERO; MAX_SLOTS];
                found.fill(Vec3::ZERO);
                sums[0] = shader.evaluate_with_derivatives(&local, wo, wi, &mut slots).value / wi.z;
                if shader.freed {
                    shader.scatter(&local, wo, wi, &slots, Vec3::splat(1.0 / wi.z), &mut found);
                }
                for (plane, derivative) in self.forward.planes.iter().zip(&found) {
                    sums[1 + plane] = *derivative;
                }
                for difference in &differences {
                    let end = |variant: &Option<Box<Variant>>| match variant {
                        Some(variant) => brdf(&variant.scene.shaders[measured.shader], wo, wi),
                        None => sums[0],
                    };
                    let change = end(&difference.above) - end(&difference.below);
                    sums[1 + difference.plane] = change * difference.scale;
                }
                if !sums.iter().all(|v| v.is_finite()) {
                    sums.fill(Vec3::ZERO);
                    invalid_samples += 1;
                }
            }
            half.extend(sums.iter().flat_map(Vec3::to_array));
        }
        half.extend_from_within(..);
        TileFilm { pixels, channels: 3 * planes, halves: 2, data: half, invalid_samples }
    }
}

impl Measured {
    /// What takes the place of first hits: the angle between normal and half vector, and that between normal and view, of
    /// a sample on the plane z = 0 with object 0; past the last sample there is nothing.
    pub(crate) fn first_hits(&self, tile: Tile, pixels: &PixelSet) -> TileFilm {
        let mut data = Vec::new();
        for pair in self.pairs(tile, pixels) {
            let mut channels = [0.0; FIRST_HIT_CHANNELS.len()];
            match pair {
                None => channels[4] = -1.0,
                Some(pair) => {
                    channels[3] = 1.0;
                    channels[8] = pair.half_angle() as f32;
                    channels[9] = libm::acos(pair.outgoing[2].clamp(-1.0, 1.0)) as f32;
                }
            }
            data.extend(channels);
        }
        let channels = FIRST_HIT_CHANNELS.len();
        TileFilm { pixels: data.len() / channels, channels, halves: 1, data, invalid_samples: 0 }
    }
}

impl Difference {
    /// Whether it moves a material.
    fn reflects(&self, shader: usize) -> bool {
        let moved =
            |v: &Option<Box<Variant>>| v.as_ref().is_some_and(|v| v.moved.get(shader).copied().unwrap_or(false));
        moved(&self.above) || moved(&self.below)
    }
}
