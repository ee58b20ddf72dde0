//! Renders through the tracer: light straight from lamps at full size, the rest at a coarse one.

use gonio_scene::capture::Model;
use gonio_scene::film::Tile;
use gonio_scene::{Assets, Capture};
use gonio_tests::hidden::film;
use gonio_tests::tile_film;
use gonio_tracer::{Prepared, Stage};
use rayon::prelude::*;

/// The capture with `factor` times the pixels a side.
pub fn enlarged(capture: &Capture, factor: u32) -> Capture {
    let own = capture.photos.iter().find(|photo| capture.camera_of(photo) != capture.camera);
    assert!(own.is_none(), "a photo has a camera of its own, which this program does not enlarge");
    film::enlarged(capture, factor, 0)
}

/// A scene, ready to be photographed.
pub struct Scene {
    /// At full size, one for each material: all others are black, so that no light is reflected twice but by one material, which
    /// a convex part and a flat board do not do.
    direct: Vec<Prepared>,
    /// As it is, at one pixel for `coarse` by `coarse`.
    all: Prepared,
    coarse: u32,
}

impl Scene {
    /// A scene of `factor` times the pixels a side; with `quick`, nothing is rendered at full size.
    pub fn new(truth: &Capture, assets: &Assets, factor: u32, coarse: u32, quick: bool) -> Self {
        let prepare = |capture: Capture| Stage::new(capture, assets.clone()).prepare(&[], &[]).unwrap();
        let lit = |which: usize| {
            let mut capture = enlarged(truth, factor);
            for material in capture.materials.iter_mut().enumerate().filter(|(i, _)| *i != which) {
                material.1.model = Model::Lambert { base_color: [0.0; 3] };
            }
            prepare(capture)
        };
        let direct = if quick { Vec::new() } else { (0..truth.materials.len()).map(lit).collect() };
        Self { direct, all: prepare(enlarged(truth, factor / coarse)), coarse }
    }

    /// What falls onto the sensor in one photo.
    pub fn film(&self, photo: usize, samples: u32, indirect: u32, seed: u64) -> Film {
        let mut rest = render(&self.all, photo, indirect, seed);
        let films = self.direct.iter().enumerate();
        let direct = films.map(|(i, scene)| render(scene, photo, samples, seed + 1000 * (1 + i as u64)));
        let direct = direct.reduce(|mut sum, film| {
            sum.pixels.iter_mut().zip(&film.pixels).for_each(|(a, b)| add(a, b, 1.0));
            sum
        });
        if let Some(direct) = &direct {
            let (coarse, width) = (self.coarse as usize, direct.width as usize);
            let share = -1.0 / (coarse * coarse) as f32;
            for (i, pixel) in direct.pixels.iter().enumerate() {
                let place = i / width / coarse * rest.width as usize + i % width / coarse;
                add(&mut rest.pixels[place], pixel, share);
            }
        }
        Film { direct, rest, coarse: self.coarse }
    }
}

/// Mean and its variance, by colour.
type Pixel = [[f32; 3]; 2];

fn add(to: &mut Pixel, from: &Pixel, factor: f32) {
    for c in 0..3 {
        to[0][c] += factor * from[0][c];
        to[1][c] += factor * factor * from[1][c];
    }
}

struct Plain {
    width: u32,
    height: u32,
    pixels: Vec<Pixel>,
}

/// Renders one photo; the variance of a mean is known by the difference of two halves.
fn render(prepared: &Prepared, photo: usize, samples: u32, seed: u64) -> Plain {
    let (width, height) = prepared.size(photo).unwrap();
    let mut pixels = vec![[[0.0; 3]; 2]; width as usize * height as usize];
    let tiles: Vec<Tile> = Tile::cover(width, height).collect();
    // In parts: films of all tiles would be as large as the photo once more.
    for tiles in tiles.chunks(1024) {
        let films: Vec<_> = tiles.par_iter().map(|tile| tile_film(prepared, photo, *tile, samples, seed)).collect();
        for (tile, film) in tiles.iter().zip(&films) {
            for p in 0..tile.len() {
                let (x, y) = (tile.x as usize + p % tile.width as usize, tile.y as usize + p / tile.width as usize);
                let (a, b) = (film.pixel(0, p), film.pixel(1, p));
                let mean = [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]));
                let variance = [0, 1, 2].map(|c| 0.25 * (a[c] - b[c]) * (a[c] - b[c]));
                pixels[y * width as usize + x] = [mean, variance];
            }
        }
    }
    Plain { width, height, pixels }
}

/// What falls onto the sensor in one photo.
pub struct Film {
    direct: Option<Plain>,
    rest: Plain,
    coarse: u32,
}

impl Film {
    /// Radiance at a pixel, and the variance that it has from being rendered.
    pub fn at(&self, x: u32, y: u32) -> ([f64; 3], [f64; 3]) {
        let mut sum = self.direct.as_ref().map_or([[0.0; 3]; 2], |d| d.pixels[(y * d.width + x) as usize]);
        let place = |at: u32, most: u32| {
            let exact = ((at as f32 + 0.5) / self.coarse as f32 - 0.5).clamp(0.0, (most - 1) as f32);
            (exact as u32, (exact as u32 + 1).min(most - 1), exact.fract())
        };
        let rest = &self.rest;
        let ((x0, x1, u), (y0, y1, v)) = (place(x, rest.width), place(y, rest.height));
        for (x, y, share) in
            [(x0, y0, (1.0 - u) * (1.0 - v)), (x1, y0, u * (1.0 - v)), (x0, y1, (1.0 - u) * v), (x1, y1, u * v)]
        {
            add(&mut sum, &rest.pixels[(y * rest.width + x) as usize], share);
        }
        (sum[0].map(f64::from), sum[1].map(f64::from))
    }
}
