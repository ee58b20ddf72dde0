//! Many pixels at a time, where their radiance is all that is wanted: paths of different pixels that have come equally
//! far are followed together. The bits are those of single samples.

use crate::bvh::{Bundle, Hits};
use crate::integrator::{First, Waves, World, first_surfaces, lights_blocks};
use crate::prepared::Prepared;
use crate::render::TileTask;
use crate::sampler::{BLOCK, Block, Branches, PixelSampler, SPLIT};
use crate::scene::View;
use glam::Vec3;
use gonio_scene::film::TileFilm;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Paths of a batch: enough for their paths to fill blocks some bounces on, few enough to stay in the cache.
const SAMPLES: usize = 4096;

/// Workspace of one tile.
struct Batch {
    numbers: Block,
    branches: Branches,
    rays: Bundle,
    hits: Hits,
    /// By pixel, sample and path.
    radiance: Vec<Vec3>,
    waves: Waves,
}

impl Prepared {
    /// The photo, where its samples can be traced in batches along their own paths.
    fn batched(&self, proposals: &Self, photo: usize) -> Option<&View> {
        let view = self.scene.views.get(photo)?;
        let plain = Arc::ptr_eq(&proposals.scene.shaders, &self.scene.shaders) && self.scene.without.is_none();
        let simple = view.camera.glare.is_none() && lights_blocks(&view.lights);
        (self.planes() == 0 && plain && simple).then_some(view)
    }

    /// Adds the means of the radiance of some pixels, in both halves, to an empty film. False, and nothing done, where
    /// batches are not possible; `None` when cancelled.
    pub(crate) fn render_batches(
        &self,
        proposals: &Self,
        task: &TileTask<'_>,
        pixels: &[usize],
        cancel: &AtomicBool,
        film: &mut TileFilm,
    ) -> Option<bool> {
        let Some(view) = self.batched(proposals, task.photo) else { return Some(false) };
        let world = World {
            geometry: &self.scene.geometry,
            shaders: &self.scene.shaders,
            proposals: &self.scene.shaders,
            shader_of: &self.scene.shader_of,
            spread: view.camera.spread,
            lights: &view.lights,
        };
        let mut batch = Batch {
            numbers: Block::new(),
            branches: Branches::new(),
            rays: Bundle::NONE,
            hits: Hits::NONE,
            radiance: Vec::new(),
            waves: Waves::new(self.scene.shaders.len()),
        };
        let (samples, split) = (task.samples.len(), SPLIT as usize);
        let paths = samples * split;
        for half in 0..2 {
            for pixels in pixels.chunks((SAMPLES / paths.max(1)).max(1)) {
                if cancel.load(Ordering::Relaxed) {
                    return None;
                }
                batch.radiance.clear();
                batch.radiance.resize(pixels.len() * paths, Vec3::ZERO);
                for (index, pixel) in pixels.iter().enumerate() {
                    batch.pixel(&world, view, task, *pixel as u32, half, index * paths);
                }
                batch.waves.follow(&world, &mut batch.radiance);
                let scale = 1.0 / samples.max(1) as f32;
                for pixel in 0..pixels.len() {
                    let mut sum = Vec3::ZERO;
                    for branches in batch.radiance[pixel * paths..(pixel + 1) * paths].chunks(split) {
                        let mut radiance = Vec3::ZERO;
                        branches.iter().for_each(|branch| radiance += *branch);
                        if radiance.is_finite() {
                            sum += radiance;
                        } else {
                            film.invalid_samples += 1;
                        }
                    }
                    film.data.extend((sum * scale).to_array());
                }
            }
        }
        Some(true)
    }
}

impl Batch {
    /// Traces one pixel's paths through their first surfaces; its first sample belongs to `slot`.
    fn pixel(&mut self, world: &World<'_>, view: &View, task: &TileTask<'_>, pixel: u32, half: u32, slot: usize) {
        let (x, y) = (task.tile.x + pixel % task.tile.width, task.tile.y + pixel / task.tile.width);
        let sampler = PixelSampler::new(task.seed, task.photo, x, y, half);
        for (offset, sample) in task.samples.clone().enumerate().step_by(BLOCK) {
            let count = (task.samples.end - sample).min(BLOCK as u32);
            self.numbers.ready = 0;
            self.numbers.fill(&sampler, sample, if view.camera.has_lens() { 4 } else { 2 });
            view.camera.rays([x as f32, y as f32], self.numbers.group(0), &mut self.rays);
            self.rays.used = u32::MAX >> (32 - count);
            self.hits = Hits::NONE;
            world.geometry.closest_bundle(&self.rays, &mut self.hits);
            if self.hits.found() != 0 {
                self.branches.fill(&sampler, sample, if world.lights.need_numbers() { 2 } else { 1 });
            }
            let (rays, hits, branches) = (&self.rays, &self.hits, &self.branches);
            let first = First { rays, hits, branches, sampler, sample, slot: slot + offset * SPLIT as usize };
            first_surfaces(world, &first, &mut self.radiance, &mut self.waves);
        }
    }
}
