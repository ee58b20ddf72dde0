//! Pictures for eyes: tone mapping, the residual's colours, and PNG inside of a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use gonio_scene::capture::{Response, srgb};
use gonio_scene::image::encode_png8;

/// The residual's colours reach to plus and minus so many standard deviations.
pub(super) const REACH: f64 = 4.0;

/// Blue over white to red, equidistant: ColorBrewer's RdBu, which colour-blind readers can tell apart.
const DIVERGING: [[u8; 3]; 9] = [
    [5, 48, 97],
    [33, 102, 172],
    [67, 147, 195],
    [146, 197, 222],
    [247, 247, 247],
    [244, 165, 130],
    [214, 96, 77],
    [178, 24, 43],
    [103, 0, 31],
];

/// What a pixel that does not count fades to.
const FADED: [u8; 3] = [128, 128, 128];

/// How photo values become pixels of a screen, alike for a photo and its render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tone {
    /// Exposure in stops; 0 where the file's values are encoded already.
    pub stops: f64,
    /// Whether values still need the sRGB curve.
    pub encode: bool,
}

impl Tone {
    /// A tone that shows all but the brightest hundredth of `values`, which count, without clipping; in tenths of a stop.
    pub fn of(mut values: Vec<f32>, response: &Response) -> Self {
        if !response.is_linear() {
            return Self { stops: 0.0, encode: false };
        }
        let place = values.len().saturating_sub(1) * 99 / 100;
        let bright = if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(place, f32::total_cmp).1 };
        let stops = if bright > 0.0 { -f64::from(bright).log2() } else { 0.0 };
        Self { stops: (stops.clamp(-60.0, 60.0) * 10.0).round() / 10.0, encode: true }
    }

    /// A photo value on the screen.
    pub fn show(self, value: f64) -> u8 {
        let light = value * self.stops.exp2();
        let encoded = if self.encode { srgb(light.clamp(0.0, 1.0)).0 } else { light };
        byte(encoded * 255.0)
    }
}

/// The colour of a residual in standard deviations.
pub(super) fn diverging(z: f64) -> [u8; 3] {
    if !z.is_finite() {
        return FADED;
    }
    let place = (z / REACH).clamp(-1.0, 1.0).mul_add(4.0, 4.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let low = (place as usize).min(7);
    #[allow(clippy::cast_precision_loss)]
    let share = place - low as f64;
    let (a, b) = (DIVERGING[low], DIVERGING[low + 1]);
    std::array::from_fn(|c| byte(f64::from(a[c]) * (1.0 - share) + f64::from(b[c]) * share))
}

/// `colour` where it counts, else a quarter of it on gray.
pub(super) fn dimmed(colour: [u8; 3], counts: bool) -> [u8; 3] {
    if counts {
        return colour;
    }
    std::array::from_fn(|c| byte(0.25 * f64::from(colour[c]) + 0.75 * f64::from(FADED[c])))
}

/// The picture as PNG; empty where it has no pixels.
pub(super) fn png(width: u32, height: u32, pixels: &[[u8; 3]]) -> Bytes {
    encode_png8("report.html", width, height, pixels).unwrap_or_default().into()
}

/// A PNG as a `data:` address; empty where there is none.
pub(super) fn data_uri(png: &[u8]) -> String {
    if png.is_empty() { String::new() } else { format!("data:image/png;base64,{}", STANDARD.encode(png)) }
}

/// The residual's scale as an SVG.
pub(super) fn legend() -> String {
    let stops: String = (0..=16)
        .map(|i| {
            let share = f64::from(i) / 16.0;
            let [r, g, b] = diverging((2.0 * share - 1.0) * REACH);
            format!("<stop offset=\"{share}\" stop-color=\"#{r:02x}{g:02x}{b:02x}\"/>")
        })
        .collect();
    let ticks: String = (-4..=4)
        .map(|z: i32| {
            let x = 200 + 45 * z;
            let sign = if z < 0 {
                "\u{2212}"
            } else if z > 0 {
                "+"
            } else {
                ""
            };
            format!("<text x=\"{x}\" y=\"34\" text-anchor=\"middle\">{sign}{}\u{3c3}</text>", z.abs())
        })
        .collect();
    format!(
        "<svg class=\"legend\" viewBox=\"0 0 400 56\" role=\"img\" aria-label=\"Colours of the residuals: blue where the photo is \
         darker than the render, white where they agree, red where the photo is brighter, from minus to plus 4 standard \
         deviations\"><defs><linearGradient id=\"residual\">{stops}</linearGradient></defs>\
         <rect x=\"20\" y=\"4\" width=\"360\" height=\"14\" fill=\"url(#residual)\"/>{ticks}\
         <text x=\"20\" y=\"52\">photo darker than render</text>\
         <text x=\"380\" y=\"52\" text-anchor=\"end\">photo brighter</text></svg>\n"
    )
}

fn byte(x: f64) -> u8 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let byte = x.round().clamp(0.0, 255.0) as u8;
    byte
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residuals_are_white_at_zero_and_saturate() {
        assert_eq!(diverging(0.0), [247, 247, 247]);
        assert_eq!(diverging(4.0), DIVERGING[8]);
        assert_eq!(diverging(-1e9), DIVERGING[0]);
        assert_eq!(diverging(2.0), DIVERGING[6]);
        assert_eq!(diverging(f64::NAN), FADED);
    }

    #[test]
    fn the_brightest_values_reach_white() {
        let values: Vec<f32> = (0..=100).map(|i| i as f32 * 0.0025).collect();
        let tone = Tone::of(values, &Response::Linear);
        assert_eq!(tone.stops, 2.0);
        assert_eq!((tone.show(0.25), tone.show(0.0), tone.show(-1.0)), (255, 0, 0));
        // sRGB of 0.5 is 0.7354.
        assert_eq!(tone.show(0.125), 188);
    }

    #[test]
    fn encoded_photos_stay_as_they_are() {
        let tone = Tone::of(vec![0.1; 4], &Response::Srgb);
        assert_eq!(tone.show(0.5), 128);
        assert_eq!(Tone::of(Vec::new(), &Response::Linear).stops, 0.0);
    }
}
