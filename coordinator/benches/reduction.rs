//! What the reduction of one task costs the coordinator: decode, merge, compare.
//!
//! `cargo bench -p gonio-coordinator --bench reduction`. A full tile of 32x32 pixels, all of which count; seven planes and
//! seven columns are a fit of colour, roughness, index and intensity.

use divan::Bencher;
use gonio_coordinator::aggregate::Measured;
use gonio_coordinator::aggregate::merge::{ChunkMerge, MergedFilm};
use gonio_coordinator::aggregate::recipe::{ActiveColumn, Recipe};
use gonio_coordinator::aggregate::statistics::{Observed, compare};
use gonio_proto::convert::film::{FilmAssembly, FilmShape, film_to_wire};
use gonio_proto::convert::task::AttemptId;
use gonio_proto::wire::from_worker::Message;
use gonio_scene::capture::{Camera, Sensor};
use gonio_scene::film::{PixelSet, Tile, TileFilm};
use gonio_scene::image::Image;
use gonio_scene::{Photograph, SensorStage};
use std::time::Duration;

fn main() {
    divan::main();
}

const TILE: Tile = Tile { x: 0, y: 0, width: 32, height: 32 };
const COLUMNS: [usize; 5] = [0, 2, 7, 50, 100];

fn film(columns: usize) -> TileFilm {
    let channels = 3 * (1 + columns);
    let data = (0..2 * 1024 * channels).map(|i| 0.5 + 0.01 * ((i * 7919 % 101) as f32 - 50.0) / 50.0).collect();
    TileFilm { pixels: 1024, channels, halves: 2, data, invalid_samples: 0 }
}

#[divan::bench(args = COLUMNS)]
fn encode(bencher: Bencher<'_, '_>, columns: usize) {
    let film = film(columns);
    let id = AttemptId { epoch: 1, evaluation: 1, task: 1, attempt: 0 };
    bencher.bench_local(|| film_to_wire(id, &film, Duration::ZERO).count());
}

#[divan::bench(args = COLUMNS)]
fn decode_and_merge(bencher: Bencher<'_, '_>, columns: usize) {
    let id = AttemptId { epoch: 1, evaluation: 1, task: 1, attempt: 0 };
    let shape = FilmShape { pixels: 1024, channels: 3 * (1 + columns), halves: 2 };
    let film = film(columns);
    bencher.bench_local(|| {
        let mut assembly = FilmAssembly::new(shape);
        for message in film_to_wire(id, &film, Duration::ZERO) {
            match message.message {
                Some(Message::Chunk(chunk)) => assembly.add(chunk).expect("a good chunk"),
                Some(Message::Commit(commit)) => {
                    let mut merge = ChunkMerge::default();
                    merge.add(0, assembly.finish(&commit).expect("a good film"), 8);
                    return merge.finish();
                }
                _ => {}
            }
        }
        MergedFilm::default()
    });
}

#[divan::bench(args = COLUMNS)]
fn compare_tile(bencher: Bencher<'_, '_>, columns: usize) {
    let film = film(columns);
    let mut merge = ChunkMerge::default();
    merge.add(0, film, 8);
    let film = merge.finish();
    let image = Image { width: 32, height: 32, pixels: vec![[0.5; 3]; 1024] };
    let photograph = Measured::All(Photograph::new(image, vec![true; 1024], 0));
    let column = |channel: usize, column: usize| ActiveColumn {
        column,
        terms: vec![(3 * (1 + column) + channel, 1.0)],
        sensor: None,
    };
    let channels = [0, 1, 2].map(|channel| (0..columns).map(|c| column(channel, c)).collect());
    let stage = SensorStage::new(&Sensor::default(), &Camera::default());
    let recipe = Recipe { factor: 1.0, stage, channels, sensor: Vec::new(), columns };
    let (pixels, sensor) = (PixelSet::from_flags([true; 1024]), Sensor::default());
    let observed = Observed { tile: TILE, pixels: &pixels, photograph: &photograph, sensor: &sensor };
    bencher.bench_local(|| compare(&film, observed, &recipe, 1.0));
}
