//! A square that faces the camera under an even sky, as files in memory.

use gonio_scene::files::MemoryFiles;
use gonio_scene::film::{PixelSet, Tile, TileFilm};
use gonio_scene::image::{Image, encode_exr};
use gonio_scene::{Assets, Capture, Parameter};
use gonio_tracer::{Prepared, Stage, TileTask};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Pixels of the photo's side; the square fills it.
pub const SIDE: u32 = 24;

/// The radiance of the sky.
pub const SKY: [f64; 3] = [1.0, 0.5, 2.0];

/// What a test's capture is made of.
pub struct World {
    pub material: String,
    pub more: String,
    pub lights: String,
    pub files: MemoryFiles,
}

/// A square of side 1 around the origin in the plane z = 0, its texture coordinates 0 to 1 from left to right and from the top
/// down as the camera sees it.
pub fn square(colours: Option<[[f32; 3]; 4]>) -> Vec<u8> {
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let more = if colours.is_some() { "property float red\nproperty float green\nproperty float blue\n" } else { "" };
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float s\n\
         property float t\n{more}element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    );
    for (k, [x, y]) in corners.iter().enumerate() {
        text += &format!("{x} {y} 0 {} {}", x + 0.5, y + 0.5);
        if let Some(colours) = colours {
            text += &colours[k].iter().map(|v| format!(" {v}")).collect::<String>();
        }
        text += "\n";
    }
    (text + "4 0 1 2 3\n").into_bytes()
}

/// The bytes of an OpenEXR whose values are `value(column, row)`.
pub fn exr(width: u32, height: u32, value: impl Fn(u32, u32) -> [f32; 3]) -> Vec<u8> {
    let pixels = (0..width * height).map(|k| value(k % width, k / width)).collect();
    encode_exr("map.exr", &Image { width, height, pixels }).unwrap()
}

impl World {
    pub fn new(material: &str, mesh: Vec<u8>) -> Self {
        let lights = format!("[[light]]\nname = \"sky\"\nkind = \"environment\"\nradiance = {SKY:?}\n");
        let mut world =
            Self { material: material.to_owned(), more: String::new(), lights, files: MemoryFiles::default() };
        world.add("square.ply", mesh);
        world
    }

    pub fn add(&mut self, path: &str, bytes: Vec<u8>) {
        self.files.0.insert(path.to_owned(), Arc::from(bytes));
    }

    pub fn capture(&self) -> Capture {
        let focal = f64::from(SIDE);
        let half = focal / 2.0;
        Capture::parse(&format!(
            "format = 1\nname = \"maps\"\n\
             [camera]\nwidth = {SIDE}\nheight = {SIDE}\nfx = {focal}\nfy = {focal}\ncx = {half}\ncy = {half}\n\
             [[material]]\nname = \"paint\"\n{}\n\
             [[object]]\nname = \"square\"\nmesh = \"square.ply\"\nmaterial = \"paint\"\n\
             object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n{}\n{}\n\
             [[photo]]\nfile = \"a.exr\"\n\
             camera_to_world = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 1], [0, 0, 0, 1]]\n",
            self.material, self.more, self.lights
        ))
        .unwrap()
    }

    pub fn stage(&self) -> Stage {
        let capture = self.capture();
        let assets = Assets::load(&capture, &self.files).unwrap();
        Stage::new(capture, assets)
    }

    pub fn columns(&self, names: &[&str]) -> Vec<Parameter> {
        let names: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
        self.capture().parameters(&names, &[]).unwrap()
    }

    /// The radiance of every pixel, `samples` in each half.
    pub fn render(&self, samples: u32) -> Vec<[f64; 3]> {
        plane(&film(&self.stage().prepare(&[], &[]).unwrap(), samples), 0)
    }
}

/// All pixels of the photo, `samples` in each half.
pub fn film(prepared: &Prepared, samples: u32) -> TileFilm {
    let tile = Tile { x: 0, y: 0, width: SIDE, height: SIDE };
    let pixels = PixelSet::from_flags(std::iter::repeat_n(true, tile.len()));
    let task = TileTask {
        photo: 0,
        tile,
        pixels: &pixels,
        samples: 0..samples,
        difference_samples: 0,
        forward_samples: 0,
        seed: 5,
    };
    prepared.render(&task, &AtomicBool::new(false)).unwrap()
}

/// Plane `plane` (0: radiance), mean of the halves.
pub fn plane(film: &TileFilm, plane: usize) -> Vec<[f64; 3]> {
    let value = |pixel: usize, channel: usize| {
        f64::from(film.pixel(0, pixel)[3 * plane + channel] + film.pixel(1, pixel)[3 * plane + channel]) / 2.0
    };
    (0..film.pixels).map(|pixel| [0, 1, 2].map(|channel| value(pixel, channel))).collect()
}

/// The root of the mean square of the difference over that of `b`.
pub fn distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let (a, b) = (a.as_flattened(), b.as_flattened());
    let change: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (change / b.iter().map(|b| b * b).sum::<f64>()).sqrt()
}
