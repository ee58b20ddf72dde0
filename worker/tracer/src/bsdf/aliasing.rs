//! The error of the reference renderer's rule for the internal reflectance of a rough boundary.
//!
//! Mitsuba 3 integrates that reflectance by 128 x 128 Gauss-Legendre nodes on the unit square, mapped to visible normals.
//! Where the mirrored ray meets the horizon the integrand falls off within a few nodes, along a line that near normal
//! incidence is parallel to the sides of the square: it crosses whole rows of nodes at once as alpha grows. The rows are
//! equally spaced in `atan(alpha)`, so that the error is a saw tooth in it. It reaches 8e-4 of the reflectance, which a
//! bright base shows; and the rule itself takes half a million nodes, several milliseconds.
//!
//! Up to 5e-5 of the reflectance (rms; in the worst cases 1.5e-4) the relative error does not depend on the index of
//! refraction, for indices from 1.25 to 1.8.

use std::f64::consts::PI;

use super::dual::Dual;

/// Table entries per row of nodes that the horizon crosses.
const STEPS: f64 = 16.0;
/// Rows of nodes per unit of `atan(alpha)`: roots of the Legendre polynomial of degree 128 lie at cosines of about
/// `pi (i - 1/4) / 128.5`.
const ROWS: f64 = 128.5 / PI;

/// Relative error in millionths, over `16 ROWS atan(alpha)`: each line spans one row of nodes.
///
/// The least-squares fit over indices 1.25, 1.37, 1.45, 1.5, 1.56, 1.67, 1.8 of the error of the rule, evaluated in full,
/// against `mean (63 integral + R(1)) / 64` as `RoughBoundary` computes it. The last line is faded to nothing by a cosine.
#[rustfmt::skip]
static MILLIONTHS: [i16; 256] = [
    0, 0, -46, -43, -42, -15, 21, 55, 76, 91, 105, 98, -73, -440, -373, -313,
    -240, -172, -93, -18, 51, 137, 192, 240, 300, 314, 273, 95, -593, -658, -525, -413,
    -292, -157, -49, 57, 146, 256, 328, 375, 403, 358, 206, -137, -788, -722, -568, -426,
    -285, -138, 14, 182, 277, 350, 406, 408, 374, 280, 48, -317, -819, -744, -536, -371,
    -198, -40, 89, 197, 294, 378, 406, 390, 301, 178, -68, -390, -764, -658, -498, -342,
    -175, -6, 146, 262, 340, 359, 361, 310, 214, 54, -149, -393, -681, -597, -423, -237,
    -88, 57, 158, 227, 268, 278, 268, 224, 157, 45, -89, -336, -565, -501, -365, -222,
    -94, -4, 78, 162, 234, 299, 339, 281, 156, 12, -181, -387, -528, -470, -341, -212,
    -59, 45, 171, 227, 247, 236, 216, 161, 67, -49, -184, -299, -403, -364, -273, -153,
    -57, 49, 120, 150, 159, 180, 180, 159, 63, -58, -182, -244, -326, -309, -249, -157,
    -87, 7, 110, 138, 149, 150, 136, 105, 53, -61, -183, -276, -294, -233, -168, -113,
    -56, -10, 31, 88, 147, 124, 85, 55, 26, -2, -85, -182, -238, -239, -211, -181,
    -120, -11, 35, 68, 97, 152, 129, 101, 37, -64, -141, -199, -243, -220, -166, -128,
    -59, 36, 63, 89, 93, 87, 58, 3, -56, -96, -132, -135, -169, -107, -107, -80,
    -61, -42, -16, 18, 65, 38, -7, -25, -11, 8, -47, -83, -117, -126, -150, -142,
    -110, -76, -9, 14, 23, 81, 45, 21, -1, -17, -30, -29, -21, -11, -5, -1,
];

/// What to multiply the mean internal reflectance by, to have it as the rule gives it, at GGX roughness `alpha`.
pub fn internal_reflectance_factor(alpha: f64) -> Dual {
    let x = STEPS * ROWS * libm::atan(alpha);
    let slope = STEPS * ROWS / (1.0 + alpha * alpha);
    let index = x as usize;
    let t = x - index as f64;
    // Catmull & Rom 1974: through the entries, with a continuous slope.
    let entry = |i: usize| i.checked_sub(1).and_then(|i| MILLIONTHS.get(i)).map_or(0.0, |&e| 1e-6 * f64::from(e));
    let [before, from, to, after] = [index, index + 1, index + 2, index + 3].map(entry);
    let c1 = 0.5 * (to - before);
    let c2 = before - 2.5 * from + 2.0 * to - 0.5 * after;
    let c3 = 1.5 * (from - to) + 0.5 * (after - before);
    Dual {
        value: 1.0 + from + t * (c1 + t * (c2 + t * c3)),
        d_alpha: slope * (c1 + t * (2.0 * c2 + t * 3.0 * c3)),
        d_ior: 0.0,
    }
}
