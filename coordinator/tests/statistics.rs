//! The comparison of films with photographs, against truths that do not share its code: a naive evaluation of the same
//! formulas, and simulated noise whose expectations are known.
//!
//! The simulations draw Gaussian noise from a counted generator, so they give the same numbers in every run; their
//! tolerances are about four standard errors of the mean over the repetitions.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

use gonio_coordinator::aggregate::Measured;
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
    Photograph::new(Image { width: SIZE.0, height: SIZE.1, pixels }, counts, 0)
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
    Recipe { factor, stage, channels, sensor: Vec::new(), columns: 2 }
}

/// The formulas of the module's documentation, written down once more without any of its shortcuts.
fn naive(film: &MergedFilm, pixels: &[usize], photo: &Photograph, sensor: &Sensor, f: f64) -> PhotoStatistics {
    let mut sums = PhotoStatistics { gram: vec![0.0; 9], noise: vec![0.0; 9], ..PhotoStatistics::default() };
    let at = |index: usize| (3 + index % 20, 2 + index / 20);
    let counted = |x: usize, y: usize| photo.counts[y * 30 + x];
    let variance = |value: f64| sensor.read_noise * sensor.read_noise + sensor.shot_noise * value.max(0.0);
    let all: Vec<(usize, usize)> =
        pixels.iter().copied().enumerate().filter(|(_, i)| counted(at(*i).0, at(*i).1)).collect();
    for (row, (k, index)) in all.iter().copied().enumerate() {
        let (x, y) = at(index);
        // The neighbour of the nearest value; where there is none, the nearer of the one before and the one after.
        let values = |index: usize| photo.image.pixels[at(index).1 * 30 + at(index).0].map(f64::from);
        let apart = |other: usize| -> f64 { (0..3).map(|c| (values(other)[c] - values(index)[c]).powi(2)).sum() };
        let beside = |other: usize| at(other).0.abs_diff(x) <= 1 && at(other).1.abs_diff(y) <= 1;
        let mut near: Vec<(usize, usize)> = all.iter().copied().filter(|(_, i)| *i != index && beside(*i)).collect();
        if near.is_empty() {
            near = [row.wrapping_sub(1), row + 1].iter().filter_map(|r| all.get(*r).copied()).collect();
        }
        let other = near.iter().min_by(|a, b| apart(a.1).total_cmp(&apart(b.1))).unwrap().0;
        let mut moved = [0.0; 3];
        for c in 0..3 {
            let near = (0..30 * 25_usize)
                .map(|i| (i % 30, i / 30))
                .filter(|(i, j)| (i.abs_diff(x) <= 1 && j.abs_diff(y) <= 1) && (*i, *j) != (x, y) && counted(*i, *j));
            let near: Vec<f64> = near.map(|(i, j)| f64::from(photo.image.pixels[j * 30 + i][c])).collect();
            // The photo's values around are kept in single precision.
            let around = f64::from((near.iter().sum::<f64>() / near.len() as f64) as f32);
            let w = 1.0 / variance(around);
            let measured = f64::from(photo.image.pixels[y * 30 + x][c]);
            let vectors = |k: usize| {
                let (a, b) = (f * film.pixel(0, k)[c], f * film.pixel(1, k)[c]);
                let (m, s) = sensor.response.apply(0, (a + b) / 2.0);
                [(0, a), (1, b)].map(|(half, light)| {
                    let l = film.pixel(half, k);
                    let green = if c == 1 { s * f * 2.0 * l[4] } else { 0.0 };
                    [m + s * (light - (a + b) / 2.0) - measured, green, s * (f * -0.5 * l[6 + c] + 0.7 * l[c])]
                })
            };
            let ([va, vb], [oa, ob]) = (vectors(k), vectors(other));
            for i in 0..3 {
                for j in 0..3 {
                    sums.gram[3 * i + j] += w * (va[i] * vb[j] + vb[i] * va[j]) / 2.0;
                }
                let (mean, own) = ((va[i] + vb[i]) / 2.0, (va[0] + vb[0]) / 2.0);
                moved[i] += w * (mean * (oa[0] - ob[0]) / 2.0 + (oa[i] - ob[i]) / 2.0 * own);
            }
            sums.observations += 1;
            sums.noise_floor += w * variance(measured);
            sums.render_noise += w * (va[0] - vb[0]) * (va[0] - vb[0]) / 4.0;
            sums.squared_error += va[0] * vb[0];
            sums.log_variance += libm::log(variance(around));
        }
        for i in 0..3 {
            for j in 0..3 {
                sums.noise[3 * i + j] += moved[i] * moved[j];
            }
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
        let observed =
            Observed { tile: TILE, pixels: &set, photograph: &Measured::All(photo.clone()), sensor: &sensor };
        let found = compare(&film, observed, &recipe(1.3, &sensor), 1.0);
        let expected = naive(&film, &indices, &photo, &sensor, 1.3);
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-6 * b.abs().max(1.0), "{a} is not {b}");
        found.gram.iter().zip(&expected.gram).for_each(|(a, b)| close(*a, *b));
        found.noise.iter().zip(&expected.noise).for_each(|(a, b)| close(*a, *b));
        close(found.squared_error, expected.squared_error);
        close(found.log_variance, expected.log_variance);
        close(found.noise_floor, expected.noise_floor);
        close(found.render_noise, expected.render_noise);
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
    compare(
        film,
        Observed { tile: TILE, pixels: &set, photograph: &Measured::All(photo.clone()), sensor },
        &recipe(1.0, sensor),
        1.0,
    )
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
fn chi_square_expects_one_at_edges_too_whatever_the_renders_noise() {
    // Shot noise, and edges between light and dark every three pixels: half of the pixels have neighbours of another brightness.
    let sensor = Sensor { read_noise: 0.005, shot_noise: 4e-4, ..Sensor::default() };
    let truth = |x: usize| if x % 6 < 3 { 0.02 } else { 1.0 };
    for render_sigma in [0.002, 0.02, 0.1] {
        let mut noise = Noise(11);
        let reduced: Vec<f64> = (0..400)
            .map(|_| {
                let mut film = render(&mut noise, 0.0, 0.1, render_sigma * 2.0_f64.sqrt());
                let pixels = TILE.len();
                for (i, pixel) in film.data.chunks_exact_mut(9).enumerate() {
                    let x = TILE.x as usize + i % pixels % TILE.width as usize;
                    pixel[..3].iter_mut().for_each(|v| *v += truth(x));
                }
                let values: Vec<f32> = (0..30 * 25 * 3)
                    .map(|i| truth(i / 3 % 30))
                    .map(|t| (t + sensor.variance(t).sqrt() * noise.normal()) as f32)
                    .collect();
                let photo = photograph(|x, y| [0, 1, 2].map(|c| values[3 * (30 * y + x) + c]), |_, _| true);
                compare_all(&film, &photo, &sensor).reduced_chi_square()
            })
            .collect();
        let (found, error) = mean(&reduced);
        // 4.5 standard errors: 7 false alarms in a million.
        assert!((found - 1.0).abs() < 4.5 * error, "render noise {render_sigma}: {found} +- {error}");
    }
}

/// No candidate moves a weight: a render that is brighter or noisier has the same floor and the same weights.
#[test]
fn weights_are_the_photographs_alone() {
    let sensor = Sensor { read_noise: 0.01, shot_noise: 1e-3, ..Sensor::default() };
    let photo = photograph(|x, y| [0.3, 0.01 * x as f32, 0.02 * y as f32], |_, _| true);
    let of = |truth: f64, sigma: f64| compare_all(&render(&mut Noise(3), truth, 0.1, sigma), &photo, &sensor);
    let (first, second) = (of(0.2, 0.0), of(7.0, 3.0));
    assert_eq!(first.noise_floor.to_bits(), second.noise_floor.to_bits());
    assert_eq!(first.log_variance.to_bits(), second.log_variance.to_bits());
    // The loss is a parabola in the render's level, whose curvature is twice the sum of the weights: the same near and far.
    let weights =
        |level: f64| (of(level + 0.1, 0.0).loss() + of(level - 0.1, 0.0).loss() - 2.0 * of(level, 0.0).loss()) / 0.02;
    assert!((weights(0.3) / weights(7.0) - 1.0).abs() < 1e-6, "{} {}", weights(0.3), weights(7.0));
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
    // Without noise: e = offset; the green column 2 d, the other -d / 2 + 0.7 * 0.5; weight 1 / sensor variance.
    let weight = TILE.len() as f64 / (0.02 * 0.02);
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
    // A plain square would contain the render's noise, which here is larger than the misfit.
    let (render, error) = mean(&grams.iter().map(|s| s.render_noise).collect::<Vec<_>>());
    let expected = 3.0 * weight * render_sigma * render_sigma;
    assert!((render - expected).abs() < 4.0 * error && expected > 2.0 * 3.0 * weight * offset * offset);
}

/// Loss and gradient know the covariance that the render's noise gives them: for noise of its own in each channel, and for one
/// that a pixel's channels share, as those of a path do.
#[test]
fn loss_and_gradient_know_their_own_covariance() {
    for (offset, render_sigma, shared) in
        [(0.0, 0.05, false), (0.03, 0.01, false), (0.03, 0.05, false), (0.03, 0.05, true)]
    {
        let mut noise = Noise(17);
        let photo = photograph(|_, _| [(0.5 - offset) as f32; 3], |_, _| true);
        let runs: Vec<PhotoStatistics> = (0..1500)
            .map(|_| {
                let mut film = render(&mut noise, 0.5, 0.1, render_sigma * 2.0_f64.sqrt());
                if shared {
                    film.data.chunks_exact_mut(9).for_each(|p| (p[1], p[2]) = (p[0], p[0]));
                }
                compare_all(&film, &photo, &sensor(0.05))
            })
            .collect();
        for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let of = |k: usize| runs.iter().map(|s| s.gram[k]).collect::<Vec<f64>>();
            let (left, right) = (of(i), of(j));
            let (middle_left, middle_right) = (mean(&left).0, mean(&right).0);
            let products: Vec<f64> =
                left.iter().zip(&right).map(|(a, b)| (a - middle_left) * (b - middle_right)).collect();
            let (observed, error) = mean(&products);
            let (claimed, _) = mean(&runs.iter().map(|s| s.noise[3 * i + j]).collect::<Vec<_>>());
            // 4.5 standard errors of the observed covariance, and those of the claims' mean.
            let tolerance = 4.5 * error + 0.02 * observed.abs();
            assert!(
                (claimed - observed).abs() < tolerance,
                "{offset} {render_sigma} {shared} {i}{j}: {claimed} for {observed}"
            );
        }
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
    compare(
        film,
        Observed { tile: TILE, pixels: &set, photograph: &Measured::All(photo.clone()), sensor: &capture.sensor },
        &recipe,
        1.0,
    )
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
        let sums = [s.noise_floor, s.render_noise, s.squared_error, s.log_variance, s.peak];
        s.gram.iter().chain(&s.noise).chain(&sums).map(|v| v.to_bits()).collect::<Vec<_>>()
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
