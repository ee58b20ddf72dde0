//! Makes the capture of a camera with many megapixels from one of a few thousand pixels: the same scene at its true values,
//! rendered anew, with noise of its own.
//!
//! `cargo run --release -p gonio-tests --example big_capture -- SOURCE OUT --factor N [--photos N] [--samples N] [--coarse N]
//! [--indirect N] [--quick] [--seed N] [--format half|png]`
//!
//! `SOURCE` is a folder of `tests/captures` without a hidden effect: `answer.json` says what the truth is. Each side gets N times
//! the pixels. Every pixel has the sensor noise that the source's pixels have, by random numbers of (seed, photo) alone.
//!
//! Light that comes straight from lamps has all the edges and hardly any noise: it is rendered at full size, with `--samples`, as the
//! sum of renders in which all materials but one are black. Light that is reflected more than once is noisy and smooth: it is
//! rendered at one pixel for `--coarse` by as many, with `--indirect` samples, and filled in between. Where an edge is seen, that
//! second light is soft over one coarse pixel. What noise is left of both renders is part of the photo: the program measures
//! its share of the variance and says so.
//!
//! `--photos`: more than the source has repeat its poses, with other noise. `--quick` renders coarse pixels alone, for timings and
//! memory: all edges are soft, so a fit of it is no measure of accuracy.
//! `half` writes OpenEXR of 16-bit floats. `png` writes 16-bit integers above a black level, clipped at one, as cameras do.

#![allow(missing_docs, clippy::unwrap_used)]

mod render;
mod truth;
mod write;

use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::{Mask, read_mask};
use gonio_scene::{Assets, Capture};
use gonio_tests::hidden::random::Random;
use render::Scene;
use std::path::{Path, PathBuf};
use write::Format;

/// Streams of random numbers: photos take those from here on, the tracer has its own.
const NOISE: u64 = 1 << 32;

struct Options {
    source: PathBuf,
    out: PathBuf,
    factor: u32,
    photos: Option<usize>,
    samples: u32,
    coarse: u32,
    indirect: u32,
    quick: bool,
    seed: u64,
    format: Format,
}

fn options() -> Options {
    let mut arguments = std::env::args().skip(1);
    let mut next = || arguments.next().expect("usage: big_capture SOURCE OUT --factor N, see the program's head");
    let mut options = Options {
        source: next().into(),
        out: next().into(),
        factor: 1,
        photos: None,
        samples: 2,
        coarse: 1,
        indirect: 128,
        quick: false,
        seed: 1,
        format: Format::Half,
    };
    while let Some(option) = arguments.next() {
        if option == "--quick" {
            options.quick = true;
            continue;
        }
        let value = arguments.next().unwrap_or_else(|| panic!("{option} needs a value"));
        let number = || value.parse::<u32>().unwrap_or_else(|_| panic!("{option} {value}: must be a whole number"));
        match option.as_str() {
            "--factor" => options.factor = number().max(1),
            "--photos" => options.photos = Some(number() as usize),
            "--samples" => options.samples = number().next_multiple_of(2).max(2),
            "--coarse" => options.coarse = number().max(1),
            "--indirect" => options.indirect = number().next_multiple_of(2).max(2),
            "--seed" => options.seed = u64::from(number()),
            "--format" => options.format = Format::named(&value),
            other => panic!("{other} is no option"),
        }
    }
    assert_eq!(options.factor % options.coarse, 0, "--coarse must divide --factor");
    options
}

fn main() {
    let options = options();
    let files = DirectoryFiles::new(&options.source);
    let source = Capture::read(&files).unwrap();
    let truth = truth::of(&source, &options.source);
    let assets = Assets::load(&source, &files).unwrap();
    std::fs::create_dir_all(options.out.join("photos")).unwrap();
    copy(&source, &options.source, &options.out);

    let mut written = render::enlarged(&source, options.factor);
    options.format.adapt(&mut written);
    let scene = Scene::new(&truth, &assets, options.factor, options.coarse, options.quick);
    let poses = source.photos.len();
    let count = options.photos.unwrap_or(poses);
    written.photos = (0..count).map(|photo| source.photos[photo % poses].clone()).collect();
    let (mut share, mut pixels) = (0.0, 0_u64);
    for photo in 0..count {
        let pose = photo % poses;
        let seed = options.seed + (photo / poses) as u64;
        let film = scene.film(pose, options.samples, options.indirect, seed);
        let mask = source.photos[pose].mask.as_ref().map(|path| read_mask(&files, path).unwrap());
        let counts = |x: u32, y: u32| {
            let at = |m: &Mask| (y / options.factor * m.width + x / options.factor) as usize;
            mask.as_ref().is_none_or(|m| m.bits[at(m)])
        };
        let mut random = Random::new(options.seed, NOISE + photo as u64);
        let (width, height) = (written.camera.width, written.camera.height);
        let (gain, sensor) = (truth.photos[pose].factor(), &written.sensor);
        let mut values = Vec::with_capacity((width * height) as usize);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let (light, noise) = film.at(x, y);
            let value = light.map(|l| gain * l + sensor.black_level);
            if counts(x, y) {
                pixels += 1;
                share += (0..3).map(|c| gain * gain * noise[c] / sensor.variance(value[c])).sum::<f64>() / 3.0;
            }
            values.push(value.map(|v| (v + sensor.variance(v).sqrt() * random.normal()) as f32));
        }
        let stem = format!("photos/{photo:02}");
        let file = options.format.write(&options.out, &stem, (width, height), &values);
        let mask = mask.as_ref().map(|_| write::mask(&options.out, &stem, (width, height), counts));
        let entry = &mut written.photos[photo];
        (entry.file, entry.mask) = (file, mask);
        eprintln!("photo {} of {count}", photo + 1);
    }
    written.name = format!("{}-{}x{}", source.name, written.camera.width, written.camera.height);
    std::fs::write(options.out.join(CAPTURE_FILE), written.to_toml().unwrap()).unwrap();
    println!("{pixels} pixels count; the renders' variance is {:.3} of the sensor's", share / pixels as f64);
}

/// Copies what the scene is made of, and what it is truly like.
fn copy(source: &Capture, from: &Path, to: &Path) {
    let assets = Assets::paths(source, false);
    for path in assets.iter().map(String::as_str).chain(["answer.json"]) {
        std::fs::copy(from.join(path), to.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
    }
}
