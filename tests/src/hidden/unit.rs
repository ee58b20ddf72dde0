//! What a strength is in numbers that can be measured: what [`hide`](super::hide) makes of it, effect by effect.

use std::f64::consts::PI;

/// The measure of an effect.
pub struct Unit {
    /// What the amount counts.
    pub noun: &'static str,
    /// The amount at a strength.
    pub amount: fn(f64) -> f64,
    /// The greatest strength at which the generator still makes what the noun says.
    pub most: f64,
}

/// Tangent of the half diagonal of the hidden captures' view, squared: 40 pixels at a focal length of 121.
const CORNER: f64 = (32.0 * 32.0 + 24.0 * 24.0) / (121.0 * 121.0);

/// The measure of an effect's strength; `None` where there is no such effect.
#[must_use]
pub fn unit(effect: &str) -> Option<Unit> {
    let of = |noun, amount, most| Some(Unit { noun, amount, most });
    match effect {
        "diffuse-roughness" => of("rad, slopes of matt facets (sigma of Oren and Nayar 1994)", |s| 0.6 * s.sqrt(), 4.0),
        // Shares of films, which end at one.
        "second-lobe" => of("% of the surface at half the roughness", |s| 40.0 * s, 2.5),
        "clear-coat" => of("% of the surface under a coat of roughness 0.1", |s| 80.0 * s, 1.25),
        "metallic" => of("% of the surface bare metal", |s| 40.0 * s, 2.5),
        "anisotropy" => of("% of the way to the widest facets, in one direction", |s| 25.0 * s, 4.0),
        "sheen" => of("% of the light on fibres comes back, in red", |s| 30.0 * s, 4.0),
        // Beyond these a colour exceeds 1, a roughness leaves the films that it is mixed from.
        "albedo-variation" => of("% of colour, root mean square over the surface", |s| 30.0 * s, 2.0),
        "roughness-variation" => of("% of roughness, root mean square over the surface", |s| 40.0 * s, 2.0),
        "translucency" => of("mm, mean free path below the surface", |s| 4.0 * s.sqrt(), 4.0),
        // Irradiance of half a sky of 0.034 by that of a lamp of 0.19 at 0.33 m.
        "ambient-light" => of("% of the lamp's irradiance, from the sky", |s| s * 3.4 * PI * 0.33 * 0.33 / 0.19, 4.0),
        "second-light" => of("% of the lamp's intensity, in green, from 0.7 m", |s| s * 15.0 / 0.19, 4.0),
        "light-position" => of("mm that the lamp stands off", |s| s * (12f64 * 12.0 + 15.0 * 15.0 + 100.0).sqrt(), 4.0),
        "light-size" => of("mm, radius of the lamp", |s| 22.0 * s.sqrt(), 4.0),
        "light-lobe" => of("as exponent of the cosine of the lamp's lobe", |s| 12.0 * s, 4.0),
        "light-flicker" => of("% of a photo's light at most, up or down", |s| 10.0 * s, 4.0),
        "pose-error" => of("mm off, and 2 degrees of turn for each", |s| s * 1.2f64.hypot(0.8), 4.0),
        // Nearer than that it would stand in the part; at strength 0 it still stands, 102 mm away.
        "missing-object" => of("mm from the part's axis to a wall 70 mm high", |s| 72.0 + 30.0 * (1.0 - s), 2.0),
        "bumps" => of("% slope, root mean square", |s| 6.0 * s, 4.0),
        "vignetting" => of("% of the light lost in the corner", |s| 25.0 * s, 4.0),
        "response-gamma" => of("more than 1, the response's exponent", |s| 0.15 * s, 4.0),
        "black-level" => of("times the read noise on every value", |s| s * 0.02 / 0.003, 4.0),
        "clipping" => of("% of the values clipped", |s| 3.0 * s, 4.0),
        "veiling-glare" => of("% of the light spread by 5 pixels", |s| 10.0 * s, 4.0),
        // A lens focused at 0.40 m, a part at 0.33 m.
        "defocus" => of("pixels, radius of the blur", |s| 121.0 * 0.014 * s.sqrt() * (1.0 / 0.33 - 1.0 / 0.40), 4.0),
        // The generator renders three pixels beyond the picture's edge.
        "lens-distortion" => of("% that the corner is moved inward", |s| s * 30.0 * CORNER, 2.0),
        "crosstalk" => of("% of green that is read as blue, the most of four leaks", |s| 6.0 * s, 4.0),
        _ => None,
    }
}
