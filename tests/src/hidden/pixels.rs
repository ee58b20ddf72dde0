//! Effects that are arithmetic on the pixels of a film, and the sensor's noise.

use super::film::Films;
use super::random::Random;
use super::vectors::V;
use super::world::World;

/// Applies an effect in place; `false` where it is none of these.
#[must_use]
pub fn apply(effect: &str, strength: f64, world: &World, films: &mut Films, random: &mut Random) -> bool {
    let s = strength;
    let camera = &world.capture.camera;
    *films = match effect {
        "vignetting" => {
            let (w, h) = (f64::from(camera.width), f64::from(camera.height));
            films.at(|_, i, v| {
                let (x, y) = (i as f64 % w, (i as f64 / w).floor());
                let square = ((x + 0.5 - w / 2.0).powi(2) + (y + 0.5 - h / 2.0).powi(2)) / (w * w + h * h) * 4.0;
                v.map(|v| v * (1.0 - 0.25 * s * square))
            })
        }
        "crosstalk" => films.at(|_, _, [r, g, b]| [r + s * 0.05 * g, g + s * 0.01 * r, b + s * (0.02 * r + 0.06 * g)]),
        "response-gamma" => films.map(|v| libm::pow(v.max(0.0), 1.0 + 0.15 * s)),
        "black-level" => films.map(|v| v + 0.02 * s),
        "clipping" => {
            let mut all: Vec<f64> = films.0.iter().flatten().flatten().copied().collect();
            all.sort_by(f64::total_cmp);
            let level = all[((1.0 - 0.03 * s) * all.len() as f64) as usize];
            films.map(|v| v.min(level))
        }
        "light-flicker" => {
            let mut gains: Vec<f64> = films.0.iter().map(|_| libm::exp(0.1 * s * random.between(-1.0, 1.0))).collect();
            gains[0] = 1.0;
            films.at(|photo, _, v| v.map(|v| v * gains[photo]))
        }
        _ => return false,
    };
    true
}

/// The noise that the capture's sensor has, at the values' own variance.
#[must_use]
pub fn noisy(films: &Films, world: &World, random: &mut Random) -> Films {
    let sensor = &world.capture.sensor;
    let mut measure = |v: f64| {
        let variance = sensor.read_noise * sensor.read_noise + sensor.shot_noise * v.max(0.0);
        v + variance.sqrt() * random.normal()
    };
    Films(films.0.iter().map(|film| film.iter().map(|v: &V| v.map(&mut measure)).collect()).collect())
}
