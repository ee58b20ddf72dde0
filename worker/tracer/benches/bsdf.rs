//! Time of one reflectance call, over directions spread on the hemisphere, and of building one material's tables.

use divan::{Bencher, black_box};
use glam::Vec3;
use gonio_tracer::bsdf::{Bsdf, Conductor, Lambert, Plastic};

/// Calls per iteration; the reported item rate is calls per second.
const CALLS: usize = 1024;

fn main() {
    divan::main();
}

#[derive(Clone, Copy, Debug)]
enum Model {
    Lambert,
    Plastic,
    PlasticCompensated,
    Conductor,
}

const MODELS: [Model; 4] = [Model::Lambert, Model::Plastic, Model::PlasticCompensated, Model::Conductor];

fn bsdf(model: Model) -> Bsdf {
    let color = Vec3::new(0.8, 0.5, 0.2);
    let built = match model {
        Model::Lambert => Lambert::new(color).map(Bsdf::Lambert),
        Model::Plastic => Plastic::new(color, 0.4, 1.5, false).map(Bsdf::Plastic),
        Model::PlasticCompensated => Plastic::new(color, 0.4, 1.5, true).map(Bsdf::Plastic),
        Model::Conductor => {
            Conductor::new(0.4, Vec3::new(0.14, 0.37, 1.44), Vec3::new(3.98, 2.39, 1.6)).map(Bsdf::Conductor)
        }
    };
    match built {
        Ok(bsdf) => bsdf,
        Err(error) => unreachable!("the parameters above are in range: {error}"),
    }
}

/// Points of the R2 low-discrepancy sequence, as three numbers.
fn numbers() -> Vec<[f32; 3]> {
    (0..CALLS)
        .map(|i| [0.754_877_7, 0.569_840_3, 0.618_034].map(|step: f64| ((i as f64 + 0.5) * step).fract() as f32))
        .collect()
}

/// Pairs of directions uniform on the hemisphere.
fn pairs() -> Vec<(Vec3, Vec3)> {
    let direction = |z: f32, turn: f32| {
        let (sin, cos) = libm::sincosf(std::f32::consts::TAU * turn);
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(radius * cos, radius * sin, z)
    };
    numbers().iter().map(|&[a, b, c]| (direction(a.max(0.01), b), direction(b.max(0.01), c))).collect()
}

#[divan::bench(args = MODELS)]
fn evaluate(bencher: Bencher, model: Model) {
    let (bsdf, pairs) = (bsdf(model), pairs());
    bencher.counter(divan::counter::ItemsCount::new(CALLS)).bench_local(|| {
        for &(wo, wi) in black_box(&pairs) {
            black_box(bsdf.evaluate(wo, wi));
        }
    });
}

#[divan::bench(args = MODELS)]
fn evaluate_with_derivatives(bencher: Bencher, model: Model) {
    let (bsdf, pairs) = (bsdf(model), pairs());
    let mut derivatives = [Vec3::ZERO; 3];
    bencher.counter(divan::counter::ItemsCount::new(CALLS)).bench_local(|| {
        for &(wo, wi) in black_box(&pairs) {
            black_box(bsdf.evaluate_with_derivatives(wo, wi, black_box(&mut derivatives)));
        }
    });
}

#[divan::bench(args = MODELS)]
fn sample(bencher: Bencher, model: Model) {
    let (bsdf, pairs, numbers) = (bsdf(model), pairs(), numbers());
    bencher.counter(divan::counter::ItemsCount::new(CALLS)).bench_local(|| {
        for (&(wo, _), &u) in black_box(&pairs).iter().zip(&numbers) {
            black_box(bsdf.sample(wo, u));
        }
    });
}

#[divan::bench(args = [Model::Plastic, Model::PlasticCompensated])]
fn build(model: Model) -> Bsdf {
    bsdf(black_box(model))
}
