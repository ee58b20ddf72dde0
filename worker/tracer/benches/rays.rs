//! How long hierarchies take to build, and rays to trace, on one thread.
//!
//! `cargo bench -p gonio-tracer --bench rays`. Side by side with Embree: `embree.py` beside this file.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::Vec3;
use gonio_tracer::bvh::{Bvh, Hit, Ray};

/// Triangles of the meshes, about.
const SIZES: [usize; 3] = [20_000, 100_000, 1_000_000];

fn main() {
    divan::main();
}

/// Hills of two scales over the unit square.
fn hills(triangles: usize) -> Vec<[Vec3; 3]> {
    let cells = (triangles as f32 / 2.0).sqrt() as usize;
    let vertex = |i: usize, j: usize| {
        let (x, y) = (i as f32 / cells as f32, j as f32 / cells as f32);
        Vec3::new(x, y, 0.1 * libm::sinf(9.0 * x) * libm::cosf(8.0 * y) + 0.01 * libm::sinf(90.0 * x + 70.0 * y))
    };
    let quad = |i, j| {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    (0..cells).flat_map(|i| (0..cells).flat_map(move |j| quad(i, j))).collect()
}

/// A pinhole camera above the hills: 4 x 4 pixels after 4 x 4 pixels.
fn camera() -> Vec<Ray> {
    let origin = Vec3::new(0.4, -0.3, 0.8);
    let pixel = |tile: usize, i: usize| {
        let (x, y) = ((tile % 64) * 4 + i % 4, (tile / 64) * 4 + i / 4);
        let target = Vec3::new(x as f32 / 256.0, y as f32 / 256.0, 0.0);
        Ray { origin, direction: target - origin, t_min: 0.0, t_max: f32::INFINITY }
    };
    (0..64 * 64).flat_map(|tile| (0..16).map(move |i| pixel(tile, i))).collect()
}

/// From where the camera's rays end into pseudorandom directions.
fn bounces(bvh: &Bvh) -> Vec<Ray> {
    let mut state = 1_u32;
    let mut number = move || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let mut rays = Vec::new();
    for ray in camera() {
        if let Some(hit) = bvh.closest(&ray) {
            let origin = ray.origin + 0.9999 * hit.t * ray.direction;
            let direction = Vec3::new(number(), number(), 0.6 * number());
            rays.push(Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY });
        }
    }
    rays
}

#[divan::bench(args = SIZES, sample_count = 5)]
fn build(bencher: Bencher, size: usize) {
    let triangles = hills(size);
    bencher.counter(ItemsCount::new(triangles.len())).bench_local(|| Bvh::build(black_box(&triangles)));
}

/// Times one function over all rays.
fn over<R>(bencher: Bencher, rays: &[Ray], trace: impl Fn(&Ray) -> R) {
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| {
        for ray in rays {
            black_box(trace(black_box(ray)));
        }
    });
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn closest_camera(bencher: Bencher, size: usize) {
    let bvh = Bvh::build(&hills(size));
    over(bencher, &camera(), |ray| bvh.closest(ray));
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn closest_camera_packets(bencher: Bencher, size: usize) {
    let bvh = Bvh::build(&hills(size));
    let rays = camera();
    let mut hits: Vec<Option<Hit>> = vec![None; rays.len()];
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| bvh.closest_packet(black_box(&rays), &mut hits));
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn closest_bounce(bencher: Bencher, size: usize) {
    let bvh = Bvh::build(&hills(size));
    over(bencher, &bounces(&bvh), |ray| bvh.closest(ray));
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn occluded_camera(bencher: Bencher, size: usize) {
    let bvh = Bvh::build(&hills(size));
    over(bencher, &camera(), |ray| bvh.occluded(ray));
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn occluded_bounce(bencher: Bencher, size: usize) {
    let bvh = Bvh::build(&hills(size));
    over(bencher, &bounces(&bvh), |ray| bvh.occluded(ray));
}
