//! How different two colours look: CIEDE2000, after Sharma, Wu and Dalal, "The CIEDE2000 color-difference formula:
//! implementation notes, supplementary test data, and mathematical observations", Color Research and Application 30, 2005.

use nalgebra::{Matrix3, Vector3};

/// From linear Rec. 709 (white at D65) to XYZ of D50: SMPTE RP 177's matrix, then Bradford's adaptation; the inverse of sRGB's
/// profile (ICC, "sRGB2014").
const TO_D50: [f64; 9] = [
    0.436_065_7,
    0.385_151_5,
    0.143_078_4, //
    0.222_493_2,
    0.716_887_0,
    0.060_616_9, //
    0.013_923_9,
    0.097_081_3,
    0.714_099_4,
];
/// XYZ of D50 as ICC profiles have it.
const D50: [f64; 3] = [0.9642, 1.0, 0.8249];

/// CIELAB under D50 of a colour in linear Rec. 709.
#[must_use]
pub fn lab_of(rgb: Vector3<f64>) -> [f64; 3] {
    let xyz = Matrix3::from_row_slice(&TO_D50) * rgb;
    let [x, y, z] = [0, 1, 2].map(|k| {
        let t = xyz[k] / D50[k];
        // CIE 15: linear below (6/29)^3.
        if t > 216.0 / 24_389.0 { libm::cbrt(t) } else { (24_389.0 / 27.0 * t + 16.0) / 116.0 }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The colour in linear Rec. 709 of a CIELAB colour under D50.
pub(super) fn rgb_of([lightness, a, b]: [f64; 3]) -> Option<Vector3<f64>> {
    let y = (lightness + 16.0) / 116.0;
    let back = |f: f64, white: f64| {
        let cube = f * f * f;
        white * if cube > 216.0 / 24_389.0 { cube } else { (116.0 * f - 16.0) * 27.0 / 24_389.0 }
    };
    let xyz = Vector3::new(back(y + a / 500.0, D50[0]), back(y, D50[1]), back(y - b / 200.0, D50[2]));
    Some(Matrix3::from_row_slice(&TO_D50).try_inverse()? * xyz)
}

/// The difference dE2000 of two CIELAB colours, with kL = kC = kH = 1.
#[must_use]
pub fn ciede2000(a: [f64; 3], b: [f64; 3]) -> f64 {
    let ([lightness, chroma, hue], rotation) = parts(a, b);
    (lightness * lightness + chroma * chroma + hue * hue + rotation * chroma * hue).max(0.0).sqrt()
}

/// Weighted differences of lightness, chroma and hue, and the rotation term RT (equations 2 to 22 there).
pub(super) fn parts(first: [f64; 3], second: [f64; 3]) -> ([f64; 3], f64) {
    let [l1, a1, b1] = first;
    let [l2, a2, b2] = second;
    let seventh = |c: f64| {
        let c7 = c * c * c * c * c * c * c;
        (c7 / (c7 + 6_103_515_625.0)).sqrt()
    };
    let g = 0.5 * (1.0 - seventh(0.5 * (a1.hypot(b1) + a2.hypot(b2))));
    let (a1, a2) = ((1.0 + g) * a1, (1.0 + g) * a2);
    let (c1, c2) = (a1.hypot(b1), a2.hypot(b2));
    let hue =
        |a: f64, b: f64| if a == 0.0 && b == 0.0 { 0.0 } else { libm::atan2(b, a).to_degrees().rem_euclid(360.0) };
    let (h1, h2) = (hue(a1, b1), hue(a2, b2));
    let gray = c1 * c2 == 0.0;
    let turn = if gray {
        0.0
    } else if (h2 - h1).abs() <= 180.0 {
        h2 - h1
    } else if h2 > h1 {
        h2 - h1 - 360.0
    } else {
        h2 - h1 + 360.0
    };
    let difference = 2.0 * (c1 * c2).sqrt() * libm::sin(0.5 * turn.to_radians());
    let middle = if gray {
        h1 + h2
    } else if (h1 - h2).abs() <= 180.0 {
        0.5 * (h1 + h2)
    } else if h1 + h2 < 360.0 {
        0.5 * (h1 + h2 + 360.0)
    } else {
        0.5 * (h1 + h2 - 360.0)
    };
    let cosine = |degrees: f64| libm::cos(degrees.to_radians());
    let t = 1.0 - 0.17 * cosine(middle - 30.0) + 0.24 * cosine(2.0 * middle) + 0.32 * cosine(3.0 * middle + 6.0)
        - 0.20 * cosine(4.0 * middle - 63.0);
    let (l, c) = (0.5 * (l1 + l2), 0.5 * (c1 + c2));
    let off = (middle - 275.0) / 25.0;
    let theta = 30.0 * libm::exp(-off * off);
    let l50 = (l - 50.0) * (l - 50.0);
    let weights = [1.0 + 0.015 * l50 / (20.0 + l50).sqrt(), 1.0 + 0.045 * c, 1.0 + 0.015 * c * t];
    let rotation = -libm::sin(2.0 * theta.to_radians()) * 2.0 * seventh(c);
    ([(l2 - l1) / weights[0], (c2 - c1) / weights[1], difference / weights[2]], rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 1 of the paper.
    const PAIRS: [([f64; 3], [f64; 3], f64); 34] = [
        ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
        ([50.0, 3.1571, -77.2803], [50.0, 0.0, -82.7485], 2.8615),
        ([50.0, 2.8361, -74.0200], [50.0, 0.0, -82.7485], 3.4412),
        ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0),
        ([50.0, -1.1848, -84.8006], [50.0, 0.0, -82.7485], 1.0),
        ([50.0, -0.9009, -85.5211], [50.0, 0.0, -82.7485], 1.0),
        ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
        ([50.0, -1.0, 2.0], [50.0, 0.0, 0.0], 2.3669),
        ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0009], 7.1792),
        ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0010], 7.1792),
        ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0011], 7.2195),
        ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0012], 7.2195),
        ([50.0, -0.001, 2.49], [50.0, 0.0009, -2.49], 4.8045),
        ([50.0, -0.001, 2.49], [50.0, 0.0010, -2.49], 4.8045),
        ([50.0, -0.001, 2.49], [50.0, 0.0011, -2.49], 4.7461),
        ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
        ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
        ([50.0, 2.5, 0.0], [61.0, -5.0, 29.0], 22.8977),
        ([50.0, 2.5, 0.0], [56.0, -27.0, -3.0], 31.9030),
        ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
        ([50.0, 2.5, 0.0], [50.0, 3.1736, 0.5854], 1.0),
        ([50.0, 2.5, 0.0], [50.0, 3.2972, 0.0], 1.0),
        ([50.0, 2.5, 0.0], [50.0, 1.8634, 0.5757], 1.0),
        ([50.0, 2.5, 0.0], [50.0, 3.2592, 0.3350], 1.0),
        ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
        ([63.0109, -31.0961, -5.8663], [62.8187, -29.7946, -4.0864], 1.2630),
        ([61.2901, 3.7196, -5.3901], [61.4292, 2.2480, -4.9620], 1.8731),
        ([35.0831, -44.1164, 3.7933], [35.0232, -40.0716, 1.5901], 1.8645),
        ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
        ([36.4612, 47.8580, 18.3852], [36.2715, 50.5065, 21.2231], 1.4146),
        ([90.8027, -2.0831, 1.4410], [91.1528, -1.6435, 0.0447], 1.4441),
        ([90.9257, -0.5406, -0.9208], [88.6381, -0.8985, -0.7239], 1.5381),
        ([6.7747, -0.2908, -2.4247], [5.8714, -0.0985, -2.2286], 0.6377),
        ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
    ];

    #[test]
    fn the_published_pairs_come_out() {
        for (a, b, expected) in PAIRS {
            for (a, b) in [(a, b), (b, a)] {
                assert!((ciede2000(a, b) - expected).abs() < 5e-5, "{a:?} {b:?}: {} {expected}", ciede2000(a, b));
            }
        }
    }

    #[test]
    fn white_is_white_and_colours_come_back() {
        let white = lab_of(Vector3::repeat(1.0));
        assert!((white[0] - 100.0).abs() < 0.01 && white[1].abs() < 0.05 && white[2].abs() < 0.05, "{white:?}");
        for lab in [[37.986, 13.555, 14.059], [20.461, -0.079, -0.973], [3.0, 1.0, -1.0]] {
            let back = lab_of(rgb_of(lab).unwrap());
            assert!(ciede2000(lab, back) < 1e-9, "{lab:?} {back:?}");
        }
    }
}
