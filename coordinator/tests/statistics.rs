//! The comparison of films with photographs, against truths that do not share its code: a naive evaluation of the same
//! formulas, and simulated noise whose expectations are known.
//!
//! The simulations draw Gaussian noise from a counted generator, so they give the same numbers in every run; their
//! tolerances are about four standard errors of the mean over the repetitions.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

use gonio_coordinator::aggregate::merge::MergedFilm;
use gonio_coordinator::aggregate::recipe::{ActiveColumn, Recipe};
use gonio_coordinator::aggregate::statistics::{Observed, compare};
use gonio_scene::capture::{Camera, Photo, Response, Sensor};
use gonio_scene::derivative::{Contribution, Plan, Plane};
use gonio_scene::film::{PixelSet, Tile};
use gonio_scene::image::Image;
use gonio_scene::{Capture, Parameter, PhotoStatistics, Photograph, SensorStage};

/// SplitMix64 (Steele, Lea, Flood 2014) and Box-Muller.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let (u, v) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * libm::log(u)).sqrt() * libm::cos(std::f64::consts::TAU * v)
    }
}

const TILE: Tile = Tile { x: 3, y: 2, width: 20, height: 16 };
const SIZE: (u32, u32) = (30, 25);

fn photograph(value: impl Fn(usize, usize) -> [f32; 3], counts: impl Fn(usize, usize) -> bool) -> Photograph {
    let place = |i: u32| ((i % SIZE.0) as usize, (i / SIZE.0) as usize);
    let pixels = (0..SIZE.0 * SIZE.1).map(|i| value(place(i).0, place(i).1)).collect();
    let counts = (0..SIZE.0 * SIZE.1).map(|i| counts(place(i).0, place(i).1)).collect();
    Photograph { image: Image { width: SIZE.0, height: SIZE.1, pixels }, counts, clipped: 0 }
}

fn all_pixels() -> PixelSet {
    PixelSet::from_flags((0..TILE.len()).map(|_| true))
}

/// Two columns: one of a colour's green channel, one of every channel plus the photo's gain.
fn recipe(factor: f64, sensor: &Sensor) -> Recipe {
    let column = |channel: usize| {
        let mut active = Vec::new();
        if channel == 1 {
            active.push(ActiveColumn { column: 0, terms: vec![(3 + channel, 2.0 * factor)], sensor: None });
        }
        active.push(ActiveColumn {
            column: 1,
            terms: vec![(6 + channel, -0.5 * factor), (channel, 0.7)],
            sensor: None,
        });
        active
    };
    let stage = SensorStage::new(sensor, &Camera::default());
    let channels = [column(0), column(1), column(2)];
    Recipe { factor, open: stage.open(), stage, channels, sensor: Vec::new(), columns: 2 }
}

/// E[1 / (1 - s + s (1 + z^2) / 2)] over a normal deviate z, by the trapezoidal rule.
fn excess(share: f64) -> f64 {
    let mut sums = (0.0, 0.0);
    for k in -20_000..=20_000 {
        let z = f64::from(k) * 5e-4;
        let density = libm::exp(-0.5 * z * z);
        sums.0 += density / (1.0 - share + share * (1.0 + z * z) / 2.0);
        sums.1 += density;
    }
    sums.0 / sums.1
}

/// The formulas of the module's documentation, written down once more without any of its shortcuts.
fn naive(film: &MergedFilm, pixels: &[usize], photo: &Photograph, sensor: &Sensor, f: f64) -> PhotoStatistics {
    let mut sums = PhotoStatistics { gram: vec![0.0; 9], ..PhotoStatistics::default() };
    let at = |index: usize| (3 + index % 20, 2 + index / 20);
    let counted = |index: &usize| photo.counts[at(*index).1 * 30 + at(*index).0];
    for c in 0..3 {
        let halves = |k: usize| (f * film.pixel(0, k)[c], f * film.pixel(1, k)[c]);
        let difference = |k: usize| {
            let (a, b) = halves(k);
            sensor.response.apply(0, 0.5 * (a + b)).1 * (a - b)
        };
        for (k, index) in pixels.iter().enumerate().filter(|(_, index)| counted(index)) {
            let (x, y) = at(*index);
            let near = |radius: usize| -> Vec<f64> {
                let others = pixels.iter().enumerate().filter(|(j, i)| *j != k && counted(i));
                let close = others.filter(|(_, i)| at(**i).0.abs_diff(x) <= radius && at(**i).1.abs_diff(y) <= radius);
                close.map(|(j, _)| difference(j) * difference(j) / 4.0).collect()
            };
            let window = if near(2).len() >= 8 { near(2) } else { near(99) };
            let n = window.len() as f64;
            let (a, b) = halves(k);
            let (m, s) = sensor.response.apply(0, (a + b) / 2.0);
            let render = window.iter().sum::<f64>() / n;
            let alone = sensor.read_noise * sensor.read_noise + sensor.shot_noise * m.max(0.0);
            let share = render / (alone + render);
            let w = 1.0 / ((alone + render) * (1.0 + 2.0 / n * share * share));
            let variance = alone + (render + difference(k) * difference(k) / 4.0) / 2.0;
            let score = 1.0 / (variance * excess(share) * (1.0 + 0.9 / n * share * share));
            let measured = f64::from(photo.image.pixels[y * 30 + x][c]);
            let vector = |half: usize, predicted: f64| {
                let l = film.pixel(half, k);
                let green = if c == 1 { s * f * 2.0 * l[4] } else { 0.0 };
                [predicted - measured, green, s * (f * -0.5 * l[6 + c] + 0.7 * l[c])]
            };
            let (va, vb) = (vector(0, m + s * (a - (a + b) / 2.0)), vector(1, m + s * (b - (a + b) / 2.0)));
            for i in 0..3 {
                for j in 0..3 {
                    sums.gram[3 * i + j] += w * (va[i] * vb[j] + vb[i] * va[j]) / 2.0;
                }
            }
            let square = ((va[0] + vb[0]) / 2.0) * ((va[0] + vb[0]) / 2.0);
            sums.observations += 1;
            sums.chi_square += score * square;
            sums.squared_error += square;
            sums.log_variance += libm::log(variance);
            sums.loss_variance += w * w * square * (va[0] - vb[0]) * (va[0] - vb[0]);
        }
    }
    sums
}

#[test]
fn equals_a_naive_evaluation_of_the_formulas() {
    for response in [Response::Linear, Response::Srgb] {
        let mut noise = Noise(7);
        let sensor = Sensor { read_noise: 0.01, shot_noise: 0.003, response, ..Sensor::default() };
        // Some pixels are not rendered, some rendered ones do not count.
        let flags: Vec<bool> = (0..TILE.len()).map(|i| i % 7 != 3 && (i < 100 || i % 3 == 0)).collect();
        let indices: Vec<usize> = (0..TILE.len()).filter(|i| flags[*i]).collect();
        let photo = photograph(|x, y| [0.3, 0.01 * x as f32, 0.02 * y as f32], |x, y| (x + y) % 5 != 0);
        let data = (0..2 * indices.len() * 9).map(|_| 0.3 + 0.1 * noise.normal()).collect();
        let film = MergedFilm { pixels: indices.len(), channels: 9, data, invalid_samples: 4 };
        let set = PixelSet::from_flags(flags);
        let observed = Observed { tile: TILE, pixels: &set, photograph: &photo, sensor: &sensor };
        let found = compare(&film, observed, &recipe(1.3, &sensor), 1.0);
        let expected = naive(&film, &indices, &photo, &sensor, 1.3);
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-11 * b.abs().max(1.0), "{a} is not {b}");
        found.gram.iter().zip(&expected.gram).for_each(|(a, b)| close(*a, *b));
        // Below a share of 0.05 the correction is a series that ends after its second term.
        assert!((found.chi_square / expected.chi_square - 1.0).abs() < 1e-4);
        close(found.squared_error, expected.squared_error);
        close(found.log_variance, expected.log_variance);
        close(found.loss_variance, expected.loss_variance);
        assert_eq!((found.observations, found.invalid_samples), (expected.observations, 4));
        assert!(found.observations > 300);
    }
}

/// One render of a constant truth with noise of a known standard deviation in each half.
fn render(noise: &mut Noise, truth: f64, derivative: f64, half_sigma: f64) -> MergedFilm {
    let data = (0..2 * TILE.len() * 9).map(|i| {
        // Noise of radiance and derivative is correlated within a sample, as it is in a path tracer.
        let mean = if i % 9 < 3 { truth } else { derivative };
        mean + half_sigma * noise.normal()
    });
    MergedFilm { pixels: TILE.len(), channels: 9, data: data.collect(), invalid_samples: 0 }
}

fn compare_all(film: &MergedFilm, photo: &Photograph, sensor: &Sensor) -> PhotoStatistics {
    let set = all_pixels();
    compare(film, Observed { tile: TILE, pixels: &set, photograph: photo, sensor }, &recipe(1.0, sensor), 1.0)
}

fn sensor(read_noise: f64) -> Sensor {
    Sensor { read_noise, ..Sensor::default() }
}

/// The mean and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

#[test]
fn chi_square_expects_one_per_observation_whichever_noise_dominates() {
    // Standard deviation of the mean of halves, against a sensor noise of 0.02.
    for render_sigma in [0.002, 0.01, 0.02, 0.04, 0.2] {
        let mut noise = Noise(11);
        let reduced: Vec<f64> = (0..150)
            .map(|_| {
                let film = render(&mut noise, 0.5, 0.1, render_sigma * 2.0_f64.sqrt());
                let values: Vec<f32> = (0..30 * 25 * 3).map(|_| (0.5 + 0.02 * noise.normal()) as f32).collect();
                let photo = photograph(|x, y| [0, 1, 2].map(|c| values[3 * (30 * y + x) + c]), |_, _| true);
                let s = compare_all(&film, &photo, &sensor(0.02));
                s.chi_square / s.observations as f64
            })
            .collect();
        let (found, error) = mean(&reduced);
        assert!((found - 1.0).abs() < 4.0 * error + 0.01, "render noise {render_sigma}: {found} +- {error}");
    }
}

#[test]
fn products_of_halves_carry_no_noise_bias() {
    let mut noise = Noise(13);
    let (offset, derivative, render_sigma) = (0.03, 0.2, 0.05);
    let photo = photograph(|_, _| [(0.5 - offset) as f32; 3], |_, _| true);
    let grams: Vec<PhotoStatistics> = (0..400)
        .map(|_| {
            compare_all(&render(&mut noise, 0.5, derivative, render_sigma * 2.0_f64.sqrt()), &photo, &sensor(0.02))
        })
        .collect();
    // Without noise: e = offset; the green column 2 d, the other -d / 2 + 0.7 * 0.5; weight 1 / (sensor + render variance).
    let weight = TILE.len() as f64 / (0.02 * 0.02 + render_sigma * render_sigma);
    let (green, other) = (2.0 * derivative, -0.5 * derivative + 0.35);
    let expected = [
        3.0 * offset * offset,
        offset * green,
        3.0 * offset * other,
        offset * green,
        green * green,
        green * other,
        3.0 * offset * other,
        green * other,
        3.0 * other * other,
    ];
    for (i, expected) in expected.iter().enumerate() {
        let (found, error) = mean(&grams.iter().map(|s| s.gram[i]).collect::<Vec<_>>());
        let expected = weight * expected;
        assert!(
            (found - expected).abs() < 4.0 * error + 0.01 * expected,
            "gram[{i}]: {found} +- {error}, not {expected}"
        );
    }
    // The plain square, by contrast, contains the render's noise, which here is larger than the misfit.
    let (plain, _) = mean(&grams.iter().map(|s| s.chi_square).collect::<Vec<_>>());
    assert!(plain > 3.0 * weight * 3.0 * offset * offset);
}

#[test]
fn the_loss_knows_its_own_variance() {
    for (offset, render_sigma) in [(0.0, 0.05), (0.03, 0.01), (0.03, 0.05)] {
        let mut noise = Noise(17);
        let photo = photograph(|_, _| [(0.5 - offset) as f32; 3], |_, _| true);
        let runs: Vec<PhotoStatistics> = (0..1500)
            .map(|_| compare_all(&render(&mut noise, 0.5, 0.1, render_sigma * 2.0_f64.sqrt()), &photo, &sensor(0.05)))
            .collect();
        let losses: Vec<f64> = runs.iter().map(|s| s.gram[0]).collect();
        let observed = {
            let (_, error) = mean(&losses);
            error * error * losses.len() as f64
        };
        let (claimed, _) = mean(&runs.iter().map(|s| s.loss_variance).collect::<Vec<_>>());
        // 1500 runs know a variance to 4 %; the weights' own noise adds a little that the claim leaves out.
        assert!(
            (claimed / observed - 1.0).abs() < 0.15,
            "offset {offset}, noise {render_sigma}: {claimed} for {observed}"
        );
    }
}

/// A capture whose sensor does everything, and a film of it that is within `noise` of smooth.
fn sensing(noise: f64) -> (Capture, MergedFilm) {
    let sensor = Sensor {
        // Far above the render's noise and without shot noise, so that the weights stay what they are.
        read_noise: 1e3,
        response: Response::Srgb,
        vignetting: [-0.3, 0.1],
        crosstalk: [0.05, 0.02, 0.04, -0.03, 0.01, 0.06],
        black_level: 0.02,
        gamma: 1.2,
        clip_level: 0.9,
        ..Sensor::default()
    };
    let camera = Camera { width: SIZE.0, height: SIZE.1, cx: 14.0, cy: 13.0, ..Camera::default() };
    let photo = Photo { file: "a.exr".to_owned(), exposure: 1.5, ..Photo::default() };
    let capture = Capture { sensor, camera, photos: vec![photo], ..Capture::default() };
    let mut draw = Noise(23);
    let half = |_: usize| -> Vec<f64> {
        let value = |i: usize| 0.1 + 0.9 * ((i / 9 * 31 + i % 9 * 7) % 101) as f64 / 101.0;
        (0..TILE.len() * 9).map(|i| value(i) * (1.0 + noise * draw.normal())).collect()
    };
    let data = [0, 1].map(half).concat();
    (capture, MergedFilm { pixels: TILE.len(), channels: 9, data, invalid_samples: 0 })
}

fn of_capture(capture: &Capture, columns: &[Parameter], film: &MergedFilm) -> PhotoStatistics {
    let planes = [Plane::Scalar { number: "one".into() }, Plane::Colour { prefix: "two".into() }];
    let mut plan = Plan::new(capture, columns).unwrap();
    plan.planes = planes.to_vec();
    plan.columns.push(vec![Contribution::Plane { plane: 0, channel: None, factor: 0.7 }]);
    plan.columns.push(vec![Contribution::Plane { plane: 1, channel: Some(2), factor: -0.4 }]);
    let recipe = Recipe::new(&plan, capture, 0);
    let photo = photograph(|x, y| [0.3, 0.01 * x as f32, 0.02 * y as f32], |_, _| true);
    let set = all_pixels();
    compare(film, Observed { tile: TILE, pixels: &set, photograph: &photo, sensor: &capture.sensor }, &recipe, 1.0)
}

#[test]
fn columns_are_derivatives_of_the_whole_statistics() {
    // A number of the sensor moves both halves' residuals by what its column says, noise or not.
    let names = ["vignetting", "crosstalk", "black_level", "gamma", "clip_level"].map(|key| format!("sensor.{key}"));
    let (capture, film) = sensing(0.1);
    let columns = capture.parameters(&names, &[]).unwrap();
    assert_eq!(columns.len(), 11);
    let found = of_capture(&capture, &columns, &film);
    for (j, column) in columns.iter().enumerate() {
        let moved = |by: f64| {
            let mut capture = capture.clone();
            capture.set_numbers(&[(column.name.clone(), column.value + by)]).unwrap();
            of_capture(&capture, &columns, &film).gram[0]
        };
        // A clip level's column counts the pixels within a thousandth of it.
        let step = if column.name == "sensor.clip_level" { 9e-4 } else { 1e-4 };
        let expected = (moved(step) - moved(-step)) / (2.0 * step);
        let column_found = 2.0 * found.gram[1 + j];
        let tolerance = 3e-3 * expected.abs() + 1e-13;
        assert!((column_found - expected).abs() < tolerance, "{}: {column_found} is not {expected}", column.name);
        assert!(expected.abs() > 1e-8, "{} does nothing", column.name);
    }

    // What moves the light moves all channels through the crosstalk.
    let (capture, mut film) = sensing(0.0);
    let gain = capture.parameters(&["photo.a.gain".to_owned()], &[]).unwrap();
    let (smooth, half) = (film.data.clone(), TILE.len() * 9);
    assert_eq!(smooth[..half], smooth[half..]);
    let found = of_capture(&capture, &gain, &film);
    for j in 0..3 {
        let mut moved = |by: f64| {
            for (pixel, from) in film.data.chunks_exact_mut(9).zip(smooth.chunks_exact(9)) {
                for c in 0..3 {
                    pixel[c] = match j {
                        0 => from[c] * (1.0 + by),
                        1 => from[c] + by * 0.7 * from[3 + c],
                        _ if c == 2 => from[c] - by * 0.4 * from[6 + c],
                        _ => from[c],
                    };
                }
            }
            of_capture(&capture, &gain, &film).gram[0]
        };
        let expected = (moved(1e-5) - moved(-1e-5)) / 2e-5;
        let column_found = 2.0 * found.gram[1 + j];
        assert!((column_found / expected - 1.0).abs() < 1e-3, "column {j}: {column_found} is not {expected}");
    }
}

#[test]
fn null_values_of_the_sensor_keep_every_bit() {
    let (mut capture, film) = sensing(0.1);
    let Sensor { read_noise, response, .. } = capture.sensor;
    capture.sensor = Sensor { read_noise: read_noise / 1e5, shot_noise: 0.01, response, ..Sensor::default() };
    let column = capture.parameters(&["photo.a.gain".to_owned()], &[]).unwrap();
    let bits = |s: &PhotoStatistics| {
        let sums = [s.loss_variance, s.chi_square, s.squared_error, s.log_variance, s.peak];
        s.gram.iter().chain(&sums).map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    let expected = of_capture(&capture, &column, &film);
    // Numbers set to their null, and a clip level that nothing reaches, are no numbers at all.
    let names = ["vignetting.k1", "vignetting.k2", "crosstalk.rg", "black_level"].map(|key| format!("sensor.{key}"));
    let nulls: Vec<_> = names.map(|name| (name, 0.0)).into_iter().chain([("sensor.clip_level".into(), 2e3)]).collect();
    capture.set_numbers(&nulls).unwrap();
    assert_eq!(bits(&of_capture(&capture, &column, &film)), bits(&expected));
    // Columns of the sensor come beside the others and leave them as they are.
    let more = capture.parameters(&["photo.a.gain".to_owned(), "sensor.vignetting".to_owned()], &[]).unwrap();
    let beside = of_capture(&capture, &more, &film);
    let kept = [0, 1, 4, 5];
    for (i, row) in kept.iter().enumerate() {
        for (j, column) in kept.iter().enumerate() {
            assert_eq!(beside.gram[row * 6 + column].to_bits(), expected.gram[i * 4 + j].to_bits());
        }
    }
}

/// A clip level's pixels above it by the render's noise alone weigh no more than those below: the render's variance is that
/// of the values before they are clipped, and what the clipped pixels add is no curvature.
#[test]
fn a_clip_level_makes_no_render_certain() {
    let mut noise = Noise(17);
    let film = render(&mut noise, 0.5, 0.1, 0.05);
    let photo = photograph(|_, _| [0.4; 3], |_, _| true);
    let open = compare_all(&film, &photo, &sensor(0.02));
    let clipped = compare_all(&film, &photo, &Sensor { clip_level: 0.4, ..sensor(0.02) });
    assert!((open.log_variance - clipped.log_variance).abs() < 1e-9 * open.log_variance.abs());
    // Noise takes a few of 960 values below the level; the others are 0.4 to the last bit, as is the photo.
    assert!(clipped.chi_square < 0.01 * open.chi_square, "{} {}", clipped.chi_square, open.chi_square);
    assert!(clipped.gram[8] < 0.05 * open.gram[8], "{} {}", clipped.gram[8], open.gram[8]);
}
