//! What the farm costs per task: embedded evaluations with a renderer that costs next to nothing.
//!
//! `cargo bench -p gonio --bench farm`. Divide a time by the tasks in its name. A task here is a tile of 32x32 pixels with
//! one derivative image: 48 KiB of film that are rendered (by a hash), sent, checked, merged and reduced.

#[path = "../tests/support/mod.rs"]
mod support;

use divan::Bencher;
use gonio::farm::Farm;
use gonio_fit::evaluate::Evaluate;
use gonio_scene::Output;
use std::ops::ControlFlow;
use std::sync::Arc;
use support::{Fake, FakeRenderer, capture_of, request};

fn main() {
    divan::main();
}

/// Two photos of 16 x 16 tiles: 512 tasks an evaluation, on one render thread.
#[divan::bench(sample_count = 20, sample_size = 1, args = [Output::Statistics, Output::Films])]
fn embedded_evaluation_of_512_tasks(bencher: Bencher<'_, '_>, output: &Output) {
    let farm = Farm::embedded_with(1, Arc::new(FakeRenderer(Arc::new(Fake::default())))).expect("threads");
    let files = capture_of(2, 512, 512);
    let request = request(&files, 2, *output);
    let mut open = farm.open(&files).expect("a good capture");
    bencher.bench_local(|| open.evaluate(&request, &mut |_| ControlFlow::Continue(())).expect("an answer"));
}

/// One task alone, from the request to the answer: what a client waits for besides rendering.
#[divan::bench(sample_count = 200, sample_size = 1)]
fn embedded_evaluation_of_1_task(bencher: Bencher<'_, '_>) {
    let farm = Farm::embedded_with(1, Arc::new(FakeRenderer(Arc::new(Fake::default())))).expect("threads");
    let files = capture_of(1, 32, 32);
    let request = request(&files, 2, Output::Statistics);
    let mut open = farm.open(&files).expect("a good capture");
    bencher.bench_local(|| open.evaluate(&request, &mut |_| ControlFlow::Continue(())).expect("an answer"));
}

/// The renderer alone, to be taken off.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn renderer_alone_512_tasks(bencher: Bencher<'_, '_>) {
    use gonio_scene::film::{PixelSet, Tile};
    use gonio_worker::renderer::{Renderer, TileTask};
    let renderer = FakeRenderer(Arc::new(Fake::default()));
    let files = capture_of(1, 32, 32);
    let capture = gonio_scene::Capture::read(&files).expect("a good capture");
    let assets = gonio_scene::Assets::load(&capture, &files).expect("a good capture");
    let columns = request(&files, 2, Output::Statistics).columns;
    let scene = renderer.load(capture, assets).prepare(&[], &columns).expect("a scene");
    let tile = Tile { x: 0, y: 0, width: 32, height: 32 };
    let pixels = PixelSet::from_flags([true; 1024]);
    let task =
        TileTask { photo: 0, tile, pixels: &pixels, samples: 0..1, difference_samples: 0, forward_samples: 0, seed: 1 };
    bencher.bench_local(|| {
        for _ in 0..512 {
            divan::black_box(scene.render(&task, &std::sync::atomic::AtomicBool::new(false)));
        }
    });
}
