//! A capture in memory, and a renderer that costs nothing and can be made to misbehave.

// Each test and benchmark uses its own part; a helper of tests may unwrap as they do.
#![allow(dead_code, missing_docs, clippy::unwrap_used)]

use gonio_scene::files::MemoryFiles;
use gonio_scene::film::{FIRST_HIT_CHANNELS, TileFilm};
use gonio_scene::image::{Image, encode_exr};
use gonio_scene::{Assets, Capture, EvaluationRequest, Output, Parameter, Result, SceneError};
use gonio_worker::renderer::{Loaded, Renderer, Scene, TileTask};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

pub const WIDTH: u32 = 70;
pub const HEIGHT: u32 = 50;

const MESH: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 1\n1 0 1\n0 1 1\n3 0 1 2\n";

/// A capture of `photos` photos, which show a constant 0.5.
pub fn capture(photos: usize) -> MemoryFiles {
    capture_of(photos, WIDTH, HEIGHT)
}

/// A capture of photos of another size.
pub fn capture_of(photos: usize, width: u32, height: u32) -> MemoryFiles {
    let mut toml = format!(
        "format = 1\nname = \"fake\"\n\
        [camera]\nwidth = {width}\nheight = {height}\nfx = 60.0\nfy = 60.0\ncx = 35.0\ncy = 25.0\n\
        [sensor]\nread_noise = 0.01\n\
        [[material]]\nname = \"m\"\nmodel = \"lambert\"\nbase_color = [0.5, 0.5, 0.5]\n\
        [[object]]\nname = \"o\"\nmesh = \"part.ply\"\nmaterial = \"m\"\n\
        object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n\
        [[light]]\nname = \"l\"\nkind = \"point\"\nposition = [0.0, 0.0, 0.0]\nintensity = [1.0, 1.0, 1.0]\n"
    );
    let mut files = MemoryFiles::default();
    let pixels = vec![[0.5; 3]; (width * height) as usize];
    let exr = encode_exr("photo.exr", &Image { width, height, pixels }).unwrap();
    for photo in 0..photos {
        toml += &format!(
            "[[photo]]\nfile = \"photos/{photo:02}.exr\"\n\
            camera_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
        );
        files.0.insert(format!("photos/{photo:02}.exr"), exr.clone().into());
    }
    files.0.insert("capture.toml".into(), Arc::from(toml.as_bytes()));
    files.0.insert("part.ply".into(), Arc::from(MESH.as_bytes()));
    files
}

/// A request for all of a capture's photos with one colour's derivatives.
pub fn request(files: &MemoryFiles, samples: u32, output: Output) -> EvaluationRequest {
    let capture = Capture::read(files).unwrap();
    let columns = capture.parameters(&["material.m.base_color".into(), "photo.00.gain".into()], &[]).unwrap();
    EvaluationRequest {
        numbers: vec![],
        columns,
        photos: (0..capture.photos.len()).collect(),
        samples,
        difference_samples: 0,
        forward_samples: 0,
        seed: 5,
        output,
    }
}

/// What the fake renderer does instead of tracing paths.
#[derive(Debug, Default)]
pub struct Fake {
    /// How long a tile takes.
    pub delay: Duration,
    /// Tiles rendered to their end.
    pub rendered: AtomicU64,
    /// Captures loaded.
    pub loaded: AtomicU64,
    /// Scenes prepared.
    pub prepared: AtomicU64,
    /// Refuses to prepare.
    pub broken: bool,
    /// Panics while rendering.
    pub panics: bool,
}

/// Hands the same fake to a worker and keeps it for looking at.
pub struct FakeRenderer(pub Arc<Fake>);

struct FakeLoaded(Arc<Fake>);

struct FakeScene {
    fake: Arc<Fake>,
    planes: usize,
}

impl Renderer for FakeRenderer {
    fn load(&self, _: Capture, assets: Assets) -> Arc<dyn Loaded> {
        assert_eq!(assets.meshes.len(), 1);
        self.0.loaded.fetch_add(1, Ordering::Relaxed);
        Arc::new(FakeLoaded(Arc::clone(&self.0)))
    }
}

impl Loaded for FakeLoaded {
    fn prepare(&self, _: &[(String, f64)], columns: &[Parameter]) -> Result<Arc<dyn Scene>> {
        if self.0.broken {
            return Err(SceneError::new("capture.toml", "folds the image", "lower k1").at("camera.distortion"));
        }
        self.0.prepared.fetch_add(1, Ordering::Relaxed);
        let planes = usize::from(columns.iter().any(|c| c.name.starts_with("material")));
        Ok(Arc::new(FakeScene { fake: Arc::clone(&self.0), planes }))
    }
}

/// Noise about 0.5 that depends on nothing but what a sample's may depend on.
fn value(photo: usize, x: u32, y: u32, half: usize, first_sample: u32, channel: usize) -> f32 {
    let mut z = [photo as u64, x.into(), y.into(), half as u64, first_sample.into(), channel as u64]
        .into_iter()
        .fold(0_u64, |z, n| (z ^ n).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    0.5 + 0.1 * ((z >> 40) as f32 / (1_u32 << 24) as f32 - 0.5)
}

impl FakeScene {
    fn film(&self, task: &TileTask<'_>, halves: usize, channels: usize, cancel: &AtomicBool) -> Option<TileFilm> {
        assert!(!self.fake.panics, "as asked");
        let end = std::time::Instant::now() + self.fake.delay;
        while std::time::Instant::now() < end {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            std::thread::sleep(Duration::from_micros(200));
        }
        let pixels: Vec<usize> = task.pixels.indices().collect();
        let mut data = Vec::with_capacity(halves * pixels.len() * channels);
        for half in 0..halves {
            for index in &pixels {
                let (x, y) = (*index as u32 % task.tile.width, *index as u32 / task.tile.width);
                let (x, y) = (task.tile.x + x, task.tile.y + y);
                data.extend((0..channels).map(|c| value(task.photo, x, y, half, task.samples.start, c)));
            }
        }
        self.fake.rendered.fetch_add(1, Ordering::Relaxed);
        Some(TileFilm { pixels: pixels.len(), channels, halves, data, invalid_samples: 1 })
    }
}

impl Scene for FakeScene {
    fn render(&self, task: &TileTask<'_>, cancel: &AtomicBool) -> Option<TileFilm> {
        self.film(task, 2, 3 * (1 + self.planes), cancel)
    }

    fn first_hits(&self, task: &TileTask<'_>, cancel: &AtomicBool) -> Option<TileFilm> {
        self.film(task, 1, FIRST_HIT_CHANNELS.len(), cancel)
    }
}
