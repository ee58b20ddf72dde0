//! What the integration tests share: where the captures lie, and a plain loop over the tracer without a farm.

#![allow(missing_docs, clippy::unwrap_used, clippy::missing_panics_doc)]

#[cfg(unix)]
pub mod browser;
#[cfg(unix)]
pub mod cluster;
pub mod evidence;
pub mod hidden;
#[cfg(unix)]
pub mod images;
pub mod noise;
pub mod operations;
pub mod pki;

use gonio_scene::film::{PixelSet, Tile, TileFilm};
use gonio_scene::{Assets, Capture};
use gonio_tracer::{Prepared, Stage, TileTask};
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// The folder of the captures that the tests use.
pub fn captures() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("captures")
}

/// One photo's two half buffers, exposed light.
pub struct Halves {
    pub halves: [Vec<[f32; 3]>; 2],
}

/// All pixels of one tile of a photo, with `samples` per pixel in both halves together.
pub fn tile_film(prepared: &Prepared, photo: usize, tile: Tile, samples: u32, seed: u64) -> TileFilm {
    let pixels = PixelSet::from_flags(std::iter::repeat_n(true, tile.len()));
    let task = TileTask {
        photo,
        tile,
        pixels: &pixels,
        samples: 0..samples / 2,
        difference_samples: 0,
        forward_samples: 0,
        seed,
    };
    prepared.render(&task, &AtomicBool::new(false)).unwrap()
}

/// Renders every photo of a capture with `samples` per pixel in all.
pub fn render(capture: &Capture, assets: Assets, samples: u32, seed: u64) -> Vec<Halves> {
    let prepared = Stage::new(capture.clone(), assets).prepare(&[], &[]).unwrap();
    (0..capture.photos.len())
        .map(|photo| {
            let (width, height) = prepared.size(photo).unwrap();
            let factor = capture.photos[photo].factor() as f32;
            let tiles: Vec<Tile> = Tile::cover(width, height).collect();
            let films: Vec<_> = tiles
                .par_iter()
                .map(|tile| {
                    let film = tile_film(&prepared, photo, *tile, samples, seed);
                    assert_eq!(film.invalid_samples, 0);
                    film
                })
                .collect();
            let mut halves = [0, 1].map(|_| vec![[0.0f32; 3]; (width * height) as usize]);
            for (tile, film) in tiles.iter().zip(&films) {
                for (h, half) in halves.iter_mut().enumerate() {
                    for p in 0..tile.len() {
                        let (x, y) = (tile.x + p as u32 % tile.width, tile.y + p as u32 / tile.width);
                        let v = film.pixel(h, p);
                        half[(y * width + x) as usize] = [v[0] * factor, v[1] * factor, v[2] * factor];
                    }
                }
            }
            Halves { halves }
        })
        .collect()
}
