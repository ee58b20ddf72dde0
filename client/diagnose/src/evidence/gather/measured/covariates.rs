//! What a residual of measured reflectance may depend on: its angles.

use crate::evidence::gather::covariates::{COVARIATES, Pixel};
use gonio_scene::reflectance::Pair;
use gonio_scene::sensor_stage::SensorStage;
use gonio_scene::{Capture, Film, Photograph};

/// Sides of the cells of outgoing directions that are even or odd in turn, radians: wide enough that what neighbouring
/// samples share falls into one half.
const CELL: [f64; 2] = [0.2, 0.4];

/// The samples of a file as pixels, from its film (the BRDF) and what was measured.
pub(crate) fn pixels(capture: &Capture, film: &Film, pairs: &[Pair], measured: &Photograph) -> Vec<Pixel> {
    let stage = SensorStage::of(capture, film.photo);
    let sensor = capture.sensor_of(film.photo);
    let sample = |(index, pair): (usize, &Pair)| {
        let brdf = [0, 1, 2].map(|c| f64::from(film.channels[c][index]));
        let value = stage.value(brdf, 0, 0).value;
        let residual = [0, 1, 2].map(|c| {
            let measured = f64::from(measured.image.pixels[index][c]);
            (measured - value[c]) / sensor.variance(value[c]).sqrt()
        });
        let mut covariates = [f64::NAN; COVARIATES.len()];
        let [half, difference, incidence, view] = angles(pair);
        covariates[..4].copy_from_slice(&[half, difference, incidence, view]);
        covariates[7] = (value[0] + value[1] + value[2]) / 3.0;
        covariates[8] = film.photo as f64;
        let azimuth = libm::atan2(pair.outgoing[1], pair.outgoing[0]);
        let cell = libm::floor(view / CELL[0]) + libm::floor(azimuth / CELL[1]);
        Pixel { residual, covariates, odd: cell.rem_euclid(2.0) > 0.5 }
    };
    pairs.iter().enumerate().filter(|(i, _)| measured.counts.get(*i) == Some(&true)).map(sample).collect()
}

/// Half angle, difference angle, incidence and view angle, radians.
fn angles(pair: &Pair) -> [f64; 4] {
    let sum = [0, 1, 2].map(|i| pair.incident[i] + pair.outgoing[i]);
    // Two unit vectors' sum is twice the cosine of the angle between either and the half vector.
    let length = libm::sqrt(sum.iter().map(|x| x * x).sum());
    let polar = |v: &[f64; 3]| libm::acos(v[2].clamp(-1.0, 1.0));
    [pair.half_angle(), libm::acos((0.5 * length).min(1.0)), polar(&pair.incident), polar(&pair.outgoing)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn angles_are_those_of_the_directions() {
        let close = |angles: [f64; 4], expected: [f64; 4]| {
            let pair = Pair::of_angles(angles);
            super::angles(&pair).iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-7, "{a} {b}"));
        };
        close([0.6, 0.0, 0.6, PI], [0.0, 0.6, 0.6, 0.6]);
        close([0.6, 1.0, 0.2, 1.0], [0.4, 0.2, 0.6, 0.2]);
        close([0.5, 0.0, 0.5, 0.0], [0.5, 0.0, 0.5, 0.5]);
    }
}
