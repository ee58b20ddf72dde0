//! From a camera's channels to Rec. 709: the mathematics of the DNG specification 1.7.1, chapter 6, "Mapping Camera Color
//! Space to CIE XYZ Space".

use nalgebra::{Matrix3, Vector3};

/// What a file states about its colours, for one or two illuminants.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Matrices {
    /// `ColorMatrix`: from XYZ to the camera, with the illuminant's temperature in kelvin where it is known.
    pub colour: Vec<(Option<f64>, Matrix3<f64>)>,
    /// `ForwardMatrix`: from the white-balanced camera to XYZ of D50.
    pub forward: Vec<(Option<f64>, Matrix3<f64>)>,
    /// `CameraCalibration`.
    pub calibration: Vec<(Option<f64>, Matrix3<f64>)>,
    /// `AnalogBalance`, on a diagonal.
    pub analog: Matrix3<f64>,
}

/// From XYZ to Rec. 709 (ITU-R BT.709-6, table 1, by SMPTE RP 177), white at D65.
const REC709: [f64; 9] = [
    3.240_969_942,
    -1.537_383_178,
    -0.498_610_760, //
    -0.969_243_636,
    1.875_967_502,
    0.041_555_057, //
    0.055_630_080,
    -0.203_976_959,
    1.056_971_514,
];
/// Bradford's cone responses (ICC.1:2022, annex E).
const BRADFORD: [f64; 9] = [0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296];
/// XYZ of D65 (x = 0.3127, y = 0.3290) and of D50 as ICC profiles have it.
const D65: [f64; 3] = [0.950_456, 1.0, 1.089_058];
const D50: [f64; 3] = [0.9642, 1.0, 0.8249];
/// Rounds of the white point's search; it settles within ten (the specification asks for no number).
const ROUNDS: usize = 30;

impl Matrices {
    /// From the camera's channels to Rec. 709 with the light's own colour, so scaled that what has the channels `neutral`
    /// has a luminance of 1. Without `neutral`, the light is taken to be D65. `None` where the file has no matrix.
    pub(super) fn to_rec709(&self, neutral: Option<[f64; 3]>) -> Option<Matrix3<f64>> {
        let xy = neutral.and_then(|neutral| self.white(neutral));
        let to_camera = self.xyz_to_camera(xy.map_or(6504.0, temperature))?;
        let back = to_camera.try_inverse()?;
        let neutral = neutral.map_or_else(
            || {
                let white = to_camera * Vector3::from(D65);
                white / white.max()
            },
            Vector3::from,
        );
        let luminance = (back * neutral)[1];
        let matrix = Matrix3::from_row_slice(&REC709) * back / luminance;
        (luminance > 0.0 && matrix.iter().all(|value| value.is_finite())).then_some(matrix)
    }

    /// From the camera's channels to Rec. 709 such that what has the channels `neutral` becomes (1, 1, 1).
    pub(super) fn balanced(&self, neutral: [f64; 3]) -> Option<Matrix3<f64>> {
        let xy = self.white(neutral)?;
        let kelvin = temperature(xy);
        let neutral = Vector3::from(neutral);
        let to_d50 = if let Some(forward) = at(&self.forward, kelvin) {
            let reference = (self.analog * self.calibrated(kelvin)).try_inverse()?;
            let gray = reference * neutral;
            forward * Matrix3::from_diagonal(&gray.map(|value| 1.0 / value)) * reference
        } else {
            let back = self.xyz_to_camera(kelvin)?.try_inverse()?;
            let white = back * neutral;
            adapt(white / white[1], Vector3::from(D50))? * back / white[1]
        };
        let matrix = Matrix3::from_row_slice(&REC709) * adapt(Vector3::from(D50), Vector3::from(D65))? * to_d50;
        // The camera's neutral is white exactly, whatever the digits of the matrices.
        let white = matrix * neutral;
        let matrix = Matrix3::from_diagonal(&white.map(|value| 1.0 / value)) * matrix;
        matrix.iter().all(|value| value.is_finite()).then_some(matrix)
    }

    /// Where the light lies (CIE 1931 x, y) whose gray has the channels `neutral`.
    fn white(&self, neutral: [f64; 3]) -> Option<[f64; 2]> {
        let mut xy = [0.3457, 0.3585];
        for _ in 0..ROUNDS {
            let xyz = self.xyz_to_camera(temperature(xy))?.try_inverse()? * Vector3::from(neutral);
            let sum = xyz.sum();
            let next = [xyz[0] / sum, xyz[1] / sum];
            if !(next[0].is_finite() && next[1] > 0.0) {
                return None;
            }
            let moved = (next[0] - xy[0]).abs() + (next[1] - xy[1]).abs();
            xy = next;
            if moved < 1e-7 {
                break;
            }
        }
        Some(xy)
    }

    fn calibrated(&self, kelvin: f64) -> Matrix3<f64> {
        at(&self.calibration, kelvin).unwrap_or_else(Matrix3::identity)
    }

    fn xyz_to_camera(&self, kelvin: f64) -> Option<Matrix3<f64>> {
        Some(self.analog * self.calibrated(kelvin) * at(&self.colour, kelvin)?)
    }
}

/// A matrix between those of two illuminants, linear in the inverse of the temperature.
fn at(matrices: &[(Option<f64>, Matrix3<f64>)], kelvin: f64) -> Option<Matrix3<f64>> {
    match matrices {
        [(Some(a), first), (Some(b), second), ..] if (a - b).abs() > 1.0 => {
            let part = ((1.0 / kelvin - 1.0 / b) / (1.0 / a - 1.0 / b)).clamp(0.0, 1.0);
            Some(first * part + second * (1.0 - part))
        }
        [(_, first), ..] => Some(*first),
        [] => None,
    }
}

/// The correlated colour temperature in kelvin (McCamy, Color Research and Application 17, 1992), kept to where it holds.
fn temperature([x, y]: [f64; 2]) -> f64 {
    let n = (x - 0.332) / (y - 0.1858);
    let kelvin = ((-449.0 * n + 3525.0) * n - 6823.3) * n + 5520.33;
    if kelvin.is_finite() { kelvin.clamp(2000.0, 25_000.0) } else { 6504.0 }
}

/// Bradford's adaptation from one white to another.
fn adapt(from: Vector3<f64>, to: Vector3<f64>) -> Option<Matrix3<f64>> {
    let cones = Matrix3::from_row_slice(&BRADFORD);
    let scale = (cones * to).component_div(&(cones * from));
    Some(cones.try_inverse()? * Matrix3::from_diagonal(&scale) * cones)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn eos() -> Matrices {
        // The matrices of a Canon EOS 6D as Adobe writes them into DNG files.
        let m = |values: [f64; 9]| Matrix3::from_row_slice(&values);
        let colour = vec![
            (Some(2856.0), m([0.7546, -0.1435, -0.0929, -0.3846, 1.1488, 0.2692, -0.0332, 0.1209, 0.637])),
            (Some(6504.0), m([0.7034, -0.0804, -0.1014, -0.442, 1.2564, 0.2058, -0.0851, 0.1994, 0.5758])),
        ];
        let forward = vec![
            (Some(2856.0), m([0.7763, 0.0065, 0.1815, 0.2364, 0.8351, -0.0715, -0.0059, -0.4228, 1.2538])),
            (Some(6504.0), m([0.7464, 0.1044, 0.1135, 0.2648, 0.9173, -0.182, 0.0113, -0.2154, 1.0292])),
        ];
        Matrices { colour, forward, calibration: Vec::new(), analog: Matrix3::identity() }
    }

    #[test]
    fn temperatures_are_those_of_standard_illuminants() {
        for (xy, kelvin) in [([0.4476, 0.4074], 2856.0), ([0.3127, 0.3290], 6504.0), ([0.3457, 0.3585], 5003.0)] {
            assert!((temperature(xy) / kelvin - 1.0).abs() < 0.005, "{} {kelvin}", temperature(xy));
        }
    }

    #[test]
    fn a_light_s_gray_becomes_white_and_the_light_s_place_is_found() {
        let matrices = eos();
        for (xy, kelvin) in [([0.4476, 0.4074], 2856.0), ([0.3127, 0.3290], 6504.0)] {
            let white = Vector3::new(xy[0] / xy[1], 1.0, (1.0 - xy[0] - xy[1]) / xy[1]);
            let seen: [f64; 3] = (matrices.xyz_to_camera(kelvin).unwrap() * white).into();
            let found = matrices.white(seen).unwrap();
            assert!((found[0] - xy[0]).abs() < 1e-3 && (found[1] - xy[1]).abs() < 1e-3, "{found:?} {xy:?}");
            let gray = matrices.balanced(seen).unwrap() * Vector3::from(seen);
            assert!((gray - Vector3::repeat(1.0)).norm() < 1e-9, "{gray}");
            // Without a balance the light keeps its colour, at luminance 1.
            let lit = matrices.to_rec709(Some(seen)).unwrap() * Vector3::from(seen);
            let expected = Matrix3::from_row_slice(&REC709) * white;
            assert!((lit - expected).norm() < 0.02, "{lit} {expected}");
        }
    }

    #[test]
    fn matrices_that_span_nothing_are_none() {
        let none = Matrices { colour: Vec::new(), ..eos() };
        assert!(none.to_rec709(None).is_none() && none.balanced([0.5, 1.0, 0.6]).is_none());
        let flat = Matrices { colour: vec![(None, Matrix3::repeat(1.0))], forward: Vec::new(), ..eos() };
        assert!(flat.to_rec709(Some([0.5, 1.0, 0.6])).is_none());
    }
}
