//! A board and a block on it, seen from above by two photos, without files.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation)]

use gonio_scene::film::{PixelSet, Tile, TileFilm};
use gonio_scene::mesh::Mesh;
use gonio_scene::{Assets, Capture, Parameter};
use gonio_tracer::{Prepared, Stage, TileTask};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Pixels of a photo's side; one tile.
pub const SIDE: u32 = 24;

/// The capture's text, in parts that tests add keys to.
#[derive(Clone)]
pub struct Text {
    pub camera: String,
    pub board: String,
    pub block: String,
    pub lights: String,
}

impl Default for Text {
    fn default() -> Self {
        Self {
            camera: String::new(),
            board: String::new(),
            block: String::new(),
            lights: lamp("lamp", "point", [0.3, -0.2, 0.8], 1.0, ""),
        }
    }
}

/// A `[[light]]` with a position.
pub fn lamp(name: &str, kind: &str, position: [f64; 3], intensity: f64, more: &str) -> String {
    format!(
        "[[light]]\nname = \"{name}\"\nkind = \"{kind}\"\nposition = {position:?}\n\
         intensity = [{intensity:?}, {intensity:?}, {intensity:?}]\n{more}\n"
    )
}

impl Text {
    pub fn capture(&self) -> Capture {
        self.parse().unwrap()
    }

    pub fn parse(&self) -> gonio_scene::Result<Capture> {
        let pose = "[[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0.6], [0, 0, 0, 1]]";
        let half = f64::from(SIDE) / 2.0;
        Capture::parse(&format!(
            "format = 1\nname = \"effects\"\n\
             [camera]\nwidth = {SIDE}\nheight = {SIDE}\nfx = 40\nfy = 40\ncx = {half}\ncy = {half}\n{camera}\n\
             [[material]]\nname = \"white\"\nmodel = \"lambert\"\nbase_color = [0.8, 0.7, 0.6]\n\
             [[material]]\nname = \"glossy\"\nmodel = \"plastic\"\nbase_color = [0.2, 0.4, 0.6]\nroughness = 0.4\n\
             ior = 1.5\n\
             [[object]]\nname = \"board\"\nmesh = \"board\"\nmaterial = \"white\"\n\
             object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n{board}\n\
             [[object]]\nname = \"block\"\nmesh = \"block\"\nmaterial = \"glossy\"\n\
             object_to_world = [[0.1, 0, 0, 0.02], [0, 0.1, 0, 0.01], [0, 0, 0.1, 0.051], [0, 0, 0, 1]]\n{block}\n\
             {lights}\n\
             [[photo]]\nfile = \"a.exr\"\ncamera_to_world = {pose}\n\
             [[photo]]\nfile = \"b.exr\"\ncamera_to_world = {pose}\n",
            camera = self.camera,
            board = self.board,
            block = self.block,
            lights = self.lights,
        ))
    }

    pub fn stage(&self) -> Stage {
        Stage::new(self.capture(), assets())
    }

    /// One photo of the capture, `samples` in each half.
    pub fn render(&self, samples: u32) -> Vec<f64> {
        radiance(&self.stage().prepare(&[], &[]).unwrap(), samples)
    }

    /// The columns of some names.
    pub fn columns(&self, names: &[&str]) -> Vec<Parameter> {
        let names: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
        self.capture().parameters(&names, &[]).unwrap()
    }
}

pub fn assets() -> Assets {
    let mesh = |positions: &[[f32; 3]], triangles: &[[u32; 3]]| {
        let (positions, triangles) = (positions.to_vec(), triangles.to_vec());
        Arc::new(Mesh { positions, normals: None, triangles, degenerate: 0 })
    };
    let board =
        mesh(&[[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]], &[[0, 1, 2], [0, 2, 3]]);
    let corners: Vec<[f32; 3]> =
        (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 0.5 } else { -0.5 })).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let sides: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let meshes = BTreeMap::from([("board".to_owned(), board), ("block".to_owned(), mesh(&corners, &sides))]);
    Assets { meshes, ..Assets::default() }
}

/// A film of a photo with seed 5.
pub fn film(prepared: &Prepared, photo: usize, samples: u32, difference_samples: u32) -> TileFilm {
    film_along(prepared, prepared, photo, samples, [difference_samples, 0])
}

/// As [`film`], along the paths of another preparation; samples of differences and of derivatives carried along the paths.
pub fn film_along(
    prepared: &Prepared,
    along: &Prepared,
    photo: usize,
    samples: u32,
    [difference_samples, forward_samples]: [u32; 2],
) -> TileFilm {
    let tile = Tile { x: 0, y: 0, width: SIDE, height: SIDE };
    let pixels = PixelSet::from_flags(std::iter::repeat_n(true, tile.len()));
    let samples = 0..samples;
    let task = TileTask { photo, tile, pixels: &pixels, samples, difference_samples, forward_samples, seed: 5 };
    prepared.render_along(along, &task, &AtomicBool::new(false)).unwrap()
}

/// All channels of plane `plane` (0: radiance), mean of the halves.
pub fn plane(film: &TileFilm, plane: usize) -> Vec<f64> {
    (0..film.pixels * 3)
        .map(|k| {
            let channel = 3 * plane + k % 3;
            f64::from(film.pixel(0, k / 3)[channel] + film.pixel(1, k / 3)[channel]) / 2.0
        })
        .collect()
}

/// The radiance of photo 0, pixel by pixel, three channels each.
pub fn radiance(prepared: &Prepared, samples: u32) -> Vec<f64> {
    plane(&film(prepared, 0, samples, 0), 0)
}

/// The root of the mean square of the difference over that of `b`.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    let square = |x: f64| x * x;
    let change: f64 = a.iter().zip(b).map(|(a, b)| square(a - b)).sum();
    (change / b.iter().map(|b| square(*b)).sum::<f64>()).sqrt()
}

pub fn mean(a: &[f64]) -> f64 {
    a.iter().sum::<f64>() / a.len() as f64
}

/// The world position at each pixel's centre.
pub fn positions(text: &Text) -> Vec<[f64; 3]> {
    let tile = Tile { x: 0, y: 0, width: SIDE, height: SIDE };
    let pixels = PixelSet::from_flags(std::iter::repeat_n(true, tile.len()));
    let prepared = text.stage().prepare(&[], &[]).unwrap();
    let film = prepared.first_hits(0, tile, &pixels, &AtomicBool::new(false)).unwrap();
    (0..tile.len()).map(|p| [5, 6, 7].map(|channel| f64::from(film.pixel(0, p)[channel]))).collect()
}
