//! Sums over pixels that a design has drawn, against those over all pixels: equal in the mean over draws, and as far apart as they
//! say. The truth is the comparison of all pixels, which `statistics.rs` holds against its formulas.

#![allow(clippy::unwrap_used, clippy::cast_precision_loss)] // a test fails by panicking

use gonio_coordinator::aggregate::Measured;
use gonio_coordinator::aggregate::measured::Drawn;
use gonio_coordinator::aggregate::merge::MergedFilm;
use gonio_coordinator::aggregate::recipe::{ActiveColumn, Recipe};
use gonio_coordinator::aggregate::statistics::{Observed, compare};
use gonio_scene::capture::{Camera, Sensor};
use gonio_scene::design::Rates;
use gonio_scene::film::{PixelSet, Tile};
use gonio_scene::image::Image;
use gonio_scene::{PhotoStatistics, Photograph, SensorStage, Values};

const SIDE: u32 = 64;
const TILE: Tile = Tile { x: 0, y: 0, width: SIDE, height: SIDE };

/// Uniform in (-1, 1), by SplitMix64.
fn random(counter: u64) -> f64 {
    let z = (counter + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn sensor() -> Sensor {
    Sensor { read_noise: 0.02, shot_noise: 0.001, ..Sensor::default() }
}

fn recipe() -> Recipe {
    let column = |channel: usize| vec![ActiveColumn { column: 0, terms: vec![(3 + channel, 1.0)], sensor: None }];
    Recipe {
        factor: 1.0,
        stage: SensorStage::new(&sensor(), &Camera::default()),
        channels: [column(0), column(1), column(2)],
        sensor: Vec::new(),
        columns: 1,
    }
}

/// A photo with the noise that its sensor says, and which of its pixels count.
fn values() -> Values {
    let noise = |i: usize| 3.0_f64.sqrt() * random(i as u64);
    let pixel = |i: usize| {
        [0, 1, 2].map(|c| {
            let light = 0.3 + 0.004 * (i % SIDE as usize) as f64;
            (light + sensor().variance(light).sqrt() * noise(3 * i + c)) as f32
        })
    };
    let count = (SIDE * SIDE) as usize;
    let image = Image { width: SIDE, height: SIDE, pixels: (0..count).map(pixel).collect() };
    Values { image, counts: (0..count).map(|i| i % 11 != 0).collect(), clipped: 0 }
}

/// A render of the truth, with noise of its own, of the pixels of a set.
fn film(pixels: &PixelSet) -> MergedFilm {
    let indices: Vec<usize> = pixels.indices().collect();
    let mut data = Vec::new();
    for half in 0..2_u64 {
        for i in &indices {
            let light = 0.3 + 0.004 * (i % SIDE as usize) as f64;
            let noise = |k: u64| 0.02 * random(1_000_000 * (1 + half) + 3 * *i as u64 + k);
            data.extend((0..3).map(|c| light + noise(c)));
            data.extend((0..3).map(|_| 1.0 + 0.01 * (i / SIDE as usize) as f64));
        }
    }
    MergedFilm { pixels: indices.len(), channels: 6, data, invalid_samples: 0 }
}

fn compared(measured: &Measured) -> PhotoStatistics {
    let pixels = measured.pixels(TILE);
    let sensor = sensor();
    let observed = Observed { tile: TILE, pixels: &pixels, photograph: measured, sensor: &sensor };
    compare(&film(&pixels), observed, &recipe(), measured.peak())
}

/// Rates of a half, a quarter and an eighth.
fn rates() -> Rates {
    Rates { cell: 32, columns: 2, codes: vec![8, 16, 24, 8] }
}

#[test]
fn drawing_every_pixel_changes_no_bit() {
    let all = Values { counts: vec![true; (SIDE * SIDE) as usize], ..values() };
    let certain = Rates { cell: 32, columns: 2, codes: vec![0; 4] };
    let drawn = compared(&Measured::Drawn(Drawn::new(&all, certain.draw(3, 0))));
    let whole = compared(&Measured::All(Photograph::new(all.image, all.counts, 0)));
    assert_eq!((&drawn.gram, &drawn.noise), (&whole.gram, &whole.noise));
    assert_eq!((drawn.observations, drawn.compared), (whole.observations, whole.compared));
    assert_eq!(whole.compared, u64::from(3 * SIDE * SIDE));
    assert_eq!((drawn.draw, whole.draw), (vec![0.0; 4], Vec::new()));
}

/// Over 400 draws the mean of every sum is that over all pixels, within four standard errors of that mean.
#[test]
fn drawn_pixels_stand_for_all_of_them() {
    const DRAWS: u64 = 400;
    let values = values();
    let whole = compared(&Measured::All(Photograph::new(values.image.clone(), values.counts.clone(), 0)));
    let sums = |s: &PhotoStatistics| {
        let [loss, gradient, _, curvature] = s.gram[..] else { panic!("two by two") };
        [loss, gradient, curvature, s.noise_floor, s.squared_error, s.log_variance, s.observations as f64]
    };
    let expected = sums(&whole);
    let found: Vec<PhotoStatistics> =
        (0..DRAWS).map(|seed| compared(&Measured::Drawn(Drawn::new(&values, rates().draw(seed, 0))))).collect();
    for (k, expected) in expected.iter().enumerate() {
        let each: Vec<f64> = found.iter().map(|s| sums(s)[k]).collect();
        let mean = each.iter().sum::<f64>() / DRAWS as f64;
        let variance = each.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (DRAWS - 1) as f64;
        let error = (variance / DRAWS as f64).sqrt();
        assert!((mean - expected).abs() < 4.0 * error, "sum {k}: {mean} ± {error}, not {expected}");
    }
    assert!(found.iter().all(|s| s.compared < whole.compared * 2 / 5 && s.compared > whole.compared / 4));
}

/// The gradient's scatter over draws is what `draw` says of it. All draws share one photo, whose noise is as large as the sensor
/// says: for it the sum over all pixels is fixed, and what varies is the draw alone, of the variance sum (1 / p - 1) (w e D)^2.
/// `draw` holds sum (h^2 - h) w D^2 over the drawn pixels, which has the same expectation over photos. Chi-square with 399 degrees of freedom
/// has a standard deviation of 7 %, the sum over 11000 observations of the photo one of 2 %: four of both together.
#[test]
fn what_the_draw_adds_to_the_gradients_variance_is_known() {
    const DRAWS: u64 = 400;
    let values = values();
    let found: Vec<PhotoStatistics> =
        (0..DRAWS).map(|seed| compared(&Measured::Drawn(Drawn::new(&values, rates().draw(seed, 0))))).collect();
    let mean = found.iter().map(|s| s.gram[1]).sum::<f64>() / DRAWS as f64;
    let scatter = found.iter().map(|s| (s.gram[1] - mean) * (s.gram[1] - mean)).sum::<f64>() / (DRAWS - 1) as f64;
    let said = found.iter().map(|s| s.draw[3]).sum::<f64>() / DRAWS as f64;
    // The render is drawn with its pixel, so that its noise scatters too: by its variance over the sensor's, within the halves' product.
    let render = found.iter().map(|s| s.render_noise / s.noise_floor).sum::<f64>() / DRAWS as f64;
    let ratio = scatter / (said * (1.0 + render));
    assert!((ratio - 1.0).abs() < 0.3, "{ratio}");
    assert!(found.iter().all(|s| s.draw[0] == 0.0 && s.draw[1] == 0.0 && s.draw[2] == 0.0));
}
