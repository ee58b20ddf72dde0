//! Films of a world, arithmetic on them, and what lies behind their pixels.

use super::vectors::{V, dot, sub, unit};
use super::world::World;
use crate::render;
use gonio_scene::Capture;
use gonio_scene::film::{PixelSet, Tile};
use gonio_tracer::Stage;
use std::sync::atomic::AtomicBool;

/// One film per photo, pixels row by row: exposed light.
#[derive(Clone)]
pub struct Films(pub Vec<Vec<V>>);

impl Films {
    /// Renders every photo.
    #[must_use]
    pub fn of(world: &World, samples: u32, seed: u64) -> Self {
        let photos = render(&world.capture, world.assets.clone(), samples, seed);
        let mean = |a: &[f32; 3], b: &[f32; 3]| [0, 1, 2].map(|c| 0.5 * (f64::from(a[c]) + f64::from(b[c])));
        Self(photos.iter().map(|p| p.halves[0].iter().zip(&p.halves[1]).map(|(a, b)| mean(a, b)).collect()).collect())
    }

    /// The mean film of several worlds, each rendered with its share of the samples.
    pub fn mean_of(worlds: impl ExactSizeIterator<Item = World>, samples: u32, seed: u64) -> Self {
        let count = worlds.len();
        let share = (samples / count as u32).max(16).next_multiple_of(2);
        let films = worlds.enumerate().map(|(i, w)| Self::of(&w, share, seed + 1000 * i as u64));
        let sum = films.reduce(|a, b| a.with(&b, |a, b| a + b)).unwrap();
        sum.map(|v| v / count as f64)
    }

    /// Channel by channel.
    #[must_use]
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.iter().map(|film| film.iter().map(|v| v.map(&f)).collect()).collect())
    }

    /// Channel by channel, with another.
    #[must_use]
    pub fn with(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let pixel = |(a, b): (&V, &V)| [0, 1, 2].map(|c| f(a[c], b[c]));
        Self(self.0.iter().zip(&other.0).map(|(a, b)| a.iter().zip(b).map(pixel).collect()).collect())
    }

    /// Pixel by pixel, given photo and index.
    #[must_use]
    pub fn at(&self, f: impl Fn(usize, usize, V) -> V) -> Self {
        let film = |(photo, film): (usize, &Vec<V>)| film.iter().enumerate().map(|(i, v)| f(photo, i, *v)).collect();
        Self(self.0.iter().enumerate().map(film).collect())
    }
}

/// Where a ray meets the world.
#[derive(Clone, Copy)]
pub struct Hit {
    pub photo: usize,
    pub on_part: bool,
    pub place: V,
    pub normal: V,
    /// How much of a matt surface's light comes from there: the cosine to the lamp.
    pub weight: f64,
}

/// What lies behind each pixel, by rays through a grid inside of it.
pub struct Hits(Vec<Vec<Vec<Hit>>>);

const GRID: u32 = 4;

impl Hits {
    /// Sends the rays.
    #[must_use]
    pub fn of(world: &World) -> Self {
        let stage = Stage::new(enlarged(&world.capture, GRID, 0), world.assets.clone());
        let prepared = stage.prepare(&[], &[]).unwrap();
        let (width, height) = (world.capture.camera.width, world.capture.camera.height);
        let lamps: Vec<V> = (0..world.capture.photos.len()).map(|photo| world.lamp_in_room(photo)).collect();
        let tile = Tile { x: 0, y: 0, width: width * GRID, height: height * GRID };
        let every = PixelSet::from_flags(std::iter::repeat_n(true, tile.len()));
        let photo = |photo: usize| {
            let film = prepared.first_hits(photo, tile, &every, &AtomicBool::new(false)).unwrap();
            let mut pixels = vec![Vec::new(); (width * height) as usize];
            for i in 0..tile.len() {
                let v = film.pixel(0, i);
                if v[4] >= 0.0 {
                    let (x, y) = (i as u32 % tile.width / GRID, i as u32 / tile.width / GRID);
                    let three = |k: usize| [v[k], v[k + 1], v[k + 2]].map(f64::from);
                    let (place, normal) = (three(5), three(1));
                    let weight = dot(unit(sub(lamps[photo], place)), normal).max(1e-4);
                    let hit = Hit { photo, on_part: v[4] == 0.0, place, normal, weight };
                    pixels[(y * width + x) as usize].push(hit);
                }
            }
            pixels
        };
        Self((0..world.capture.photos.len()).map(photo).collect())
    }

    /// Mean of a factor on a matt surface's light over the part's share of a pixel; `none` where the part is not in it.
    pub fn on_part(&self, photo: usize, pixel: usize, none: f64, f: impl Fn(&Hit) -> f64) -> f64 {
        Self::mean(self.0[photo][pixel].iter().filter(|h| h.on_part), none, f)
    }

    /// Mean of such a factor over a pixel; `none` where there is nothing.
    pub fn on_all(&self, photo: usize, pixel: usize, none: f64, f: impl Fn(&Hit) -> f64) -> f64 {
        Self::mean(self.0[photo][pixel].iter(), none, f)
    }

    /// Where a pixel's rays meet the part, and their share of the pixel.
    pub fn part(&self, photo: usize, pixel: usize) -> (impl Iterator<Item = &Hit>, f64) {
        let hits = || self.0[photo][pixel].iter().filter(|h| h.on_part);
        (hits(), hits().count() as f64 / f64::from(GRID * GRID))
    }

    fn mean<'a>(hits: impl Iterator<Item = &'a Hit>, none: f64, f: impl Fn(&Hit) -> f64) -> f64 {
        let (sum, total) = hits.fold((0.0, 0.0), |(sum, total), h| (sum + h.weight * f(h), total + h.weight));
        if total > 0.0 { sum / total } else { none }
    }
}

/// The capture with `margin` more pixels on every side, each cut into `grid` x `grid`.
#[must_use]
pub fn enlarged(capture: &Capture, grid: u32, margin: u32) -> Capture {
    let mut large = capture.clone();
    let (camera, g) = (&mut large.camera, f64::from(grid));
    camera.width = (camera.width + 2 * margin) * grid;
    camera.height = (camera.height + 2 * margin) * grid;
    (camera.cx, camera.cy) = ((camera.cx + f64::from(margin)) * g, (camera.cy + f64::from(margin)) * g);
    (camera.fx, camera.fy) = (camera.fx * g, camera.fy * g);
    large
}
