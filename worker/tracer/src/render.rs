//! Renders tiles: the two half buffers with their derivative images, and first hits.

use crate::bvh::{Hit, Ray};
use crate::integrator::{Tally, World, trace};
use crate::prepared::{Prepared, View};
use crate::sampler::PixelSampler;
use glam::Vec3;
use gonio_scene::film::{FIRST_HIT_CHANNELS, PixelSet, Tile, TileFilm};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// What to render.
#[derive(Debug, Clone)]
pub struct TileTask<'a> {
    /// Index of the photo.
    pub photo: usize,
    /// Rectangle of the photo.
    pub tile: Tile,
    /// The wanted pixels of the tile.
    pub pixels: &'a PixelSet,
    /// Sample indices, in each half.
    pub samples: Range<u32>,
    /// Seed of every random number.
    pub seed: u64,
}

/// Workspace of one tile.
struct Buffers {
    /// d throughput / d parameter.
    path: Vec<Vec3>,
    /// One path's findings by plane.
    found: Vec<Vec3>,
    /// Sums over a pixel's samples: radiance, then the planes.
    sums: Vec<Vec3>,
}

impl Prepared {
    /// The planes of the films that this scene renders, radiance not counted.
    #[must_use]
    pub fn planes(&self) -> usize {
        self.plan.planes.len()
    }

    /// Renders one tile: two halves of `3 * (1 + planes)` channels. `None` when cancelled, or where there is no such photo.
    ///
    /// A sample that is not finite in radiance or any derivative is counted and adds zero to both.
    #[must_use]
    pub fn render(&self, task: &TileTask<'_>, cancel: &AtomicBool) -> Option<TileFilm> {
        self.render_along(self, task, cancel)
    }

    /// As [`Prepared::render`], along the very paths that `proposals` would choose: the estimator whose derivative the
    /// forward derivatives are. `proposals` must be of the same capture.
    #[must_use]
    pub fn render_along(&self, proposals: &Self, task: &TileTask<'_>, cancel: &AtomicBool) -> Option<TileFilm> {
        let pixels: Vec<usize> = task.pixels.indices().collect();
        let channels = 3 * (1 + self.planes());
        let mut film = TileFilm {
            pixels: pixels.len(),
            channels,
            halves: 2,
            data: Vec::with_capacity(2 * pixels.len() * channels),
            invalid_samples: 0,
        };
        let forward = self.planes();
        let mut buffers = Buffers {
            path: vec![Vec3::ZERO; forward],
            found: vec![Vec3::ZERO; forward],
            sums: vec![Vec3::ZERO; 1 + forward],
        };
        for half in 0..2 {
            for index in &pixels {
                if cancel.load(Ordering::Relaxed) {
                    return None;
                }
                let x = task.tile.x + (*index as u32) % task.tile.width;
                let y = task.tile.y + (*index as u32) / task.tile.width;
                film.invalid_samples += self.pixel(proposals, task, x, y, half, &mut buffers)?;
                let scale = 1.0 / task.samples.len().max(1) as f32;
                film.data.extend(buffers.sums.iter().flat_map(|sum| (*sum * scale).to_array()));
            }
        }
        Some(film)
    }

    /// Sums one pixel's samples into `buffers.sums`; returns how many were not finite.
    fn pixel(
        &self,
        proposals: &Self,
        task: &TileTask<'_>,
        x: u32,
        y: u32,
        half: u32,
        buffers: &mut Buffers,
    ) -> Option<u64> {
        let sampler = PixelSampler::new(task.seed, task.photo, x, y, half);
        let Buffers { path, found, sums } = buffers;
        sums.fill(Vec3::ZERO);
        let mut invalid = self.sum(proposals, task, x, y, &sampler, path, found, sums)?;
        let mut one = [Vec3::ZERO];
        for (plane, [plus, minus], scale) in &self.differences {
            for (scene, sign) in [(plus, *scale), (minus, -*scale)] {
                one[0] = Vec3::ZERO;
                invalid += scene.sum(proposals, task, x, y, &sampler, &mut [], &mut [], &mut one)?;
                sums[1 + plane] += one[0] * sign;
            }
        }
        Some(invalid)
    }

    /// Adds the samples of one pixel, radiance first, then as many planes as `found` has.
    #[allow(clippy::too_many_arguments)]
    fn sum(
        &self,
        proposals: &Self,
        task: &TileTask<'_>,
        x: u32,
        y: u32,
        sampler: &PixelSampler,
        path: &mut [Vec3],
        found: &mut [Vec3],
        sums: &mut [Vec3],
    ) -> Option<u64> {
        let view = self.views.get(task.photo)?;
        let world = self.world(proposals, view);
        let same = std::ptr::eq(world.proposals, world.shaders);
        let mut invalid = 0;
        for index in task.samples.clone() {
            let mut numbers = sampler.sample(index);
            let [u, v, ..] = numbers.next4();
            let ray = view.ray(x as f32 + u, y as f32 + v);
            let first = self.geometry.closest(&ray);
            found.fill(Vec3::ZERO);
            let mut tally = Tally { radiance: Vec3::ZERO, derivatives: found };
            if same {
                trace::<true>(&world, ray, first, &mut numbers, path, &mut tally);
            } else {
                trace::<false>(&world, ray, first, &mut numbers, path, &mut tally);
            }
            let radiance = tally.radiance;
            if radiance.is_finite() && found.iter().all(|d| d.is_finite()) {
                sums[0] += radiance;
                for (sum, derivative) in sums[1..].iter_mut().zip(found.iter()) {
                    *sum += *derivative;
                }
            } else {
                invalid += 1;
            }
        }
        Some(invalid)
    }

    fn world<'a>(&'a self, proposals: &'a Self, view: &'a View) -> World<'a> {
        World {
            geometry: &self.geometry,
            shaders: &self.shaders,
            proposals: &proposals.shaders,
            shader_of: &self.shader_of,
            lights: &view.lights,
        }
    }

    /// What the rays through pixel centres hit first: one half of [`FIRST_HIT_CHANNELS`].
    #[must_use]
    pub fn first_hits(&self, photo: usize, tile: Tile, pixels: &PixelSet, cancel: &AtomicBool) -> Option<TileFilm> {
        let view = self.views.get(photo)?;
        let channels = FIRST_HIT_CHANNELS.len();
        let indices: Vec<usize> = pixels.indices().collect();
        let mut data = Vec::with_capacity(indices.len() * channels);
        for index in &indices {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let x = tile.x + (*index as u32) % tile.width;
            let y = tile.y + (*index as u32) / tile.width;
            let ray = view.ray(x as f32 + 0.5, y as f32 + 0.5);
            data.extend(self.first_hit(view, &ray, self.geometry.closest(&ray)));
        }
        Some(TileFilm { pixels: indices.len(), channels, halves: 1, data, invalid_samples: 0 })
    }

    fn first_hit(&self, view: &View, ray: &Ray, hit: Option<Hit>) -> [f32; FIRST_HIT_CHANNELS.len()] {
        let Some(hit) = hit else {
            let mut nothing = [0.0; FIRST_HIT_CHANNELS.len()];
            nothing[4] = -1.0;
            return nothing;
        };
        let surface = self.geometry.surface(&hit);
        let (p, n) = (surface.position, surface.normal);
        let view_direction = -ray.direction;
        let angle = |v: Vec3| libm::acosf(n.dot(v).clamp(-1.0, 1.0));
        let half =
            view.lights.principal_direction(p).and_then(|l| (l + view_direction).try_normalize()).map_or(0.0, angle);
        let depth = (p - view.camera.origin).dot(view.camera.forward);
        [depth, n.x, n.y, n.z, surface.object as f32, p.x, p.y, p.z, half, angle(view_direction)]
    }

    /// Width and height of a photo.
    #[must_use]
    pub fn size(&self, photo: usize) -> Option<(u32, u32)> {
        self.views.get(photo).map(|v| (v.width, v.height))
    }
}

impl View {
    /// The camera ray through an image position in pixels.
    fn ray(&self, x: f32, y: f32) -> Ray {
        Ray { origin: self.camera.origin, direction: self.camera.direction(x, y), t_min: 0.0, t_max: f32::INFINITY }
    }
}
