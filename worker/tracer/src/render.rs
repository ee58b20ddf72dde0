//! Renders tiles: the two half buffers with their derivative images, and first hits.

use crate::bvh::{Bundle, Hit, Hits, Ray};
use crate::camera::Glare;
use crate::difference::Difference;
use crate::integrator::{Start, Tally, World, trace_camera};
use crate::prepared::Prepared;
use crate::reflectance::Measured;
use crate::sampler::{Aside, BLOCK, Block, Branches, PixelSampler};
use crate::scene::{Scene, Variant, View};
use crate::shader::Shader;
use glam::Vec3;
use gonio_scene::film::{FIRST_HIT_CHANNELS, PixelSet, Tile, TileFilm};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What to render.
#[derive(Debug, Clone)]
pub struct TileTask<'a> {
    /// Index of the photo, or of measured reflectance behind the photos.
    pub photo: usize,
    /// Rectangle of the photo.
    pub tile: Tile,
    /// The wanted pixels of the tile.
    pub pixels: &'a PixelSet,
    /// Sample indices, in each half.
    pub samples: Range<u32>,
    /// How many of the samples, from the first on, finite differences take; 0: all.
    pub difference_samples: u32,
    /// The same of derivatives that are carried along the paths.
    pub forward_samples: u32,
    /// Seed of every random number.
    pub seed: u64,
}

impl TileTask<'_> {
    /// Samples in each half of derivatives that are to have `wanted`.
    fn share(&self, wanted: u32) -> usize {
        match wanted as usize {
            0 => self.samples.len(),
            some => some.min(self.samples.len()),
        }
    }
}

/// Workspace of one tile.
struct Buffers {
    /// d throughput / d parameter of the materials' planes.
    path: Vec<Vec3>,
    /// One path's findings by forward plane.
    found: Vec<Vec3>,
    /// Sums over a pixel's samples: radiance, then the planes.
    sums: Vec<Vec3>,
    /// The samples that differences start from.
    middle: Vec<Traced>,
    /// The samples that are traced together.
    block: SampleBlock,
}

/// Successive samples of one pixel.
struct SampleBlock {
    numbers: Block,
    branches: Branches,
    rays: Bundle,
    first: Hits,
}

/// What is known of a sample before it is traced.
#[derive(Clone, Copy)]
struct Known<'a> {
    /// What its camera ray hits.
    first: Option<Option<Hit>>,
    /// The block that holds its numbers, and its lane there.
    block: Option<(&'a SampleBlock, usize)>,
}

impl Known<'_> {
    const NOTHING: Self = Self { first: None, block: None };
}

/// One sample of a pixel.
#[derive(Clone, Copy)]
struct Traced {
    radiance: Vec3,
    first: Option<Hit>,
}

/// One pixel of a photo.
struct Pixel {
    photo: usize,
    x: u32,
    y: u32,
    sampler: PixelSampler,
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
        if let Some(measured) = self.scene.measured(task.photo) {
            return Some(self.reflect(measured, task));
        }
        let pixels: Vec<usize> = task.pixels.indices().collect();
        let channels = 3 * (1 + self.planes());
        let mut film = TileFilm {
            pixels: pixels.len(),
            channels,
            halves: 2,
            data: Vec::with_capacity(2 * pixels.len() * channels),
            invalid_samples: 0,
        };
        if self.render_batches(proposals, task, &pixels, cancel, &mut film)? {
            return Some(film);
        }
        let mut buffers = Buffers {
            path: vec![Vec3::ZERO; self.forward.materials],
            found: vec![Vec3::ZERO; self.forward.planes.len()],
            sums: vec![Vec3::ZERO; 1 + self.planes()],
            middle: Vec::new(),
            block: SampleBlock {
                numbers: Block::new(),
                branches: Branches::new(),
                rays: Bundle::NONE,
                first: Hits::NONE,
            },
        };
        // Where no number moves what this photo sees, a difference is zero and costs nothing.
        let differences: Vec<_> = self.differences.iter().filter(|d| d.matters(task.photo)).collect();
        for half in 0..2 {
            for index in &pixels {
                if cancel.load(Ordering::Relaxed) {
                    return None;
                }
                let x = task.tile.x + (*index as u32) % task.tile.width;
                let y = task.tile.y + (*index as u32) / task.tile.width;
                let sampler = PixelSampler::new(task.seed, task.photo, x, y, half);
                let pixel = Pixel { photo: task.photo, x, y, sampler };
                film.invalid_samples += self.pixel(proposals, task, &pixel, &differences, &mut buffers)?;
                film.data.extend(buffers.sums.iter().flat_map(Vec3::to_array));
            }
        }
        Some(film)
    }

    /// Puts one pixel's means into `buffers.sums`; returns how many samples were not finite.
    fn pixel(
        &self,
        proposals: &Self,
        task: &TileTask<'_>,
        pixel: &Pixel,
        differences: &[&Difference],
        buffers: &mut Buffers,
    ) -> Option<u64> {
        let Buffers { path, found, sums, middle, block } = buffers;
        let chosen = &proposals.scene.shaders;
        sums.fill(Vec3::ZERO);
        middle.clear();
        let kept = if differences.is_empty() { 0 } else { task.share(task.difference_samples) };
        let carried = task.share(task.forward_samples);
        let mut invalid = 0;
        for start in task.samples.clone().step_by(BLOCK) {
            let count = (task.samples.end - start).min(BLOCK as u32) as usize;
            let together = self.scene.first_hits(pixel, start..start + count as u32, block)?;
            for lane in 0..count {
                let index = start + lane as u32;
                let carries = ((index - task.samples.start) as usize) < carried;
                let (path, found) = if carries { (&mut path[..], &mut found[..]) } else { Default::default() };
                let known = if together {
                    Known { first: Some(block.first.get(lane)), block: Some((block, lane)) }
                } else {
                    Known::NOTHING
                };
                let traced = self.scene.sample(chosen, pixel, index, known, path, found)?;
                if middle.len() < kept {
                    middle.push(traced);
                }
                if traced.radiance.is_finite() && found.iter().all(|d| d.is_finite()) {
                    sums[0] += traced.radiance;
                    for (plane, derivative) in self.forward.planes.iter().zip(found.iter()) {
                        sums[1 + plane] += *derivative;
                    }
                } else {
                    invalid += 1;
                }
            }
        }
        let [scale, scale_of_carried] = [task.samples.len(), carried].map(|count| 1.0 / count.max(1) as f32);
        sums[0] *= scale;
        sums[1..].iter_mut().for_each(|sum| *sum *= scale_of_carried);
        for difference in differences {
            let mut sum = Vec3::ZERO;
            for (index, middle) in task.samples.clone().zip(middle.iter()) {
                let end = |variant: &Option<Box<Variant>>| match variant.as_deref() {
                    Some(variant) if variant.differs[pixel.photo] => variant.sample(chosen, pixel, index, middle),
                    _ => Some(middle.radiance),
                };
                // Sample by sample: sums would lose the digits in which the two differ.
                let change = end(&difference.above)? - end(&difference.below)?;
                if change.is_finite() {
                    sum += change;
                } else {
                    invalid += 1;
                }
            }
            sums[1 + difference.plane] = sum * (difference.scale / middle.len().max(1) as f32);
        }
        Some(invalid)
    }

    /// What the rays through pixel centres hit first: one half of [`FIRST_HIT_CHANNELS`].
    #[must_use]
    pub fn first_hits(&self, photo: usize, tile: Tile, pixels: &PixelSet, cancel: &AtomicBool) -> Option<TileFilm> {
        if let Some(measured) = self.scene.measured(photo) {
            return Some(measured.first_hits(tile, pixels));
        }
        let view = self.scene.views.get(photo)?;
        let channels = FIRST_HIT_CHANNELS.len();
        let indices: Vec<usize> = pixels.indices().collect();
        let mut data = Vec::with_capacity(indices.len() * channels);
        for index in &indices {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let x = tile.x + (*index as u32) % tile.width;
            let y = tile.y + (*index as u32) / tile.width;
            let ray = view.camera.centre_ray(x as f32 + 0.5, y as f32 + 0.5);
            data.extend(self.first_hit(view, &ray, self.scene.geometry.closest(&ray)));
        }
        Some(TileFilm { pixels: indices.len(), channels, halves: 1, data, invalid_samples: 0 })
    }

    fn first_hit(&self, view: &View, ray: &Ray, hit: Option<Hit>) -> [f32; FIRST_HIT_CHANNELS.len()] {
        let Some(hit) = hit else {
            let mut nothing = [0.0; FIRST_HIT_CHANNELS.len()];
            nothing[4] = -1.0;
            return nothing;
        };
        let surface = self.scene.geometry.surface(&hit);
        let (p, n) = (surface.position, surface.normal);
        let view_direction = -ray.direction;
        let angle = |v: Vec3| libm::acosf(n.dot(v).clamp(-1.0, 1.0));
        let half =
            view.lights.principal_direction(p).and_then(|l| (l + view_direction).try_normalize()).map_or(0.0, angle);
        let depth = (p - view.camera.origin).dot(view.camera.forward);
        [
            depth,
            n.x,
            n.y,
            n.z,
            self.scene.geometry.object_of(hit.triangle) as f32,
            p.x,
            p.y,
            p.z,
            half,
            angle(view_direction),
        ]
    }

    /// Width and height of a photo.
    #[must_use]
    pub fn size(&self, photo: usize) -> Option<(u32, u32)> {
        let view = self.scene.views.get(photo).map(|v| (v.width, v.height));
        view.or_else(|| self.scene.measured(photo).map(Measured::size))
    }
}

impl Scene {
    /// The measured reflectance with index `target`, which photos come before.
    fn measured(&self, target: usize) -> Option<&Measured> {
        self.measured.get(target.checked_sub(self.views.len())?)
    }

    /// Finds what the camera rays of samples of a pixel, at most [`BLOCK`] of them, hit first: the same bits as one by
    /// one. False, and nothing found, where they are to be traced one by one.
    fn first_hits(&self, pixel: &Pixel, samples: Range<u32>, block: &mut SampleBlock) -> Option<bool> {
        let view = self.views.get(pixel.photo)?;
        if self.without.is_some() {
            return Some(false);
        }
        let SampleBlock { numbers, branches, rays, first } = block;
        numbers.ready = 0;
        numbers.fill(&pixel.sampler, samples.start, if view.camera.has_lens() { 4 } else { 2 });
        view.camera.rays([pixel.x as f32, pixel.y as f32], numbers.group(0), rays);
        rays.used = u32::MAX >> (32 - samples.len().min(BLOCK));
        *first = Hits::NONE;
        self.geometry.closest_bundle(rays, first);
        if first.found() != 0 {
            branches.fill(&pixel.sampler, samples.start, 2);
        }
        Some(true)
    }

    /// Traces a sample of a pixel along the paths that `proposals` choose. `found` receives the derivatives; both slices may be empty.
    fn sample(
        &self,
        proposals: &Arc<[Shader]>,
        pixel: &Pixel,
        index: u32,
        known: Known<'_>,
        path: &mut [Vec3],
        found: &mut [Vec3],
    ) -> Option<Traced> {
        let view = self.views.get(pixel.photo)?;
        let numbers = pixel.sampler.sample(index);
        let mut choice = None;
        let mut choose = |which: usize| choice.get_or_insert_with(|| numbers.aside(Aside::Choice).next4())[which];
        let geometry = match &self.without {
            Some((share, without)) if choose(0) >= *share => without,
            _ => &self.geometry,
        };
        let glare = view.camera.glare.map(|glare| (glare, glare.offset(choose(1), choose(2))));
        let world = World {
            geometry,
            shaders: &self.shaders,
            proposals,
            shader_of: &self.shader_of,
            spread: view.camera.spread,
            lights: &view.lights,
        };
        found.fill(Vec3::ZERO);
        let mut tally = Tally { radiance: Vec3::ZERO, derivatives: found };
        let mut follow = |sampler: PixelSampler, known: Known<'_>, (dx, dy): (f32, f32), tally: &mut Tally<'_>| {
            let camera = sampler.sample(index);
            let [x, y, u, v] = known.block.map_or(camera, |(block, lane)| camera.from(&block.numbers, lane)).next4();
            let ray = view.camera.ray(pixel.x as f32 + x + dx, pixel.y as f32 + y + dy, u, v);
            let first = known.first.unwrap_or_else(|| geometry.closest(&ray));
            let start = Start::camera(ray, first);
            let branch = |branch: u32| {
                let numbers = sampler.branch(index, branch);
                known.block.map_or(numbers, |(block, ray)| {
                    let (block, lane) = block.branches.of(ray, branch);
                    numbers.from(block, lane)
                })
            };
            if Arc::ptr_eq(proposals, &self.shaders) {
                trace_camera::<true>(&world, start, branch, path, tally);
            } else {
                trace_camera::<false>(&world, start, branch, path, tally);
            }
            first
        };
        let first = follow(pixel.sampler, known, (0.0, 0.0), &mut tally);
        if let Some((Glare { fraction, .. }, offset)) = glare {
            // (1 - f) own + f other, as f ((1 - f) / f own + other), so that both add to one tally.
            tally.scale((1.0 - fraction) / fraction);
            follow(pixel.sampler.aside(Aside::Glare), Known::NOTHING, offset, &mut tally);
            tally.scale(fraction);
        }
        Some(Traced { radiance: tally.radiance, first })
    }
}

impl Variant {
    /// The radiance of a sample whose path in the other scene is known.
    fn sample(&self, proposals: &Arc<[Shader]>, pixel: &Pixel, index: u32, other: &Traced) -> Option<Vec3> {
        let known = Known { first: self.same_first_hits[pixel.photo].then_some(other.first), block: None };
        self.scene.sample(proposals, pixel, index, known, &mut [], &mut []).map(|traced| traced.radiance)
    }
}
