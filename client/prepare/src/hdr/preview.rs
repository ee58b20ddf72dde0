//! A map as an ordinary picture.

use gonio_scene::image::Image;

/// Tone-maps a radiance map to sRGB codes: the global operator of Reinhard et al. (SIGGRAPH 2002), equations 1 to 4, with key
/// 0.18 and the 99.8th percentile as white.
pub fn preview(map: &Image) -> Vec<[u8; 3]> {
    let luminance = |pixel: &[f32; 3]| f64::from(0.2126 * pixel[0] + 0.7152 * pixel[1] + 0.0722 * pixel[2]);
    let mut lit: Vec<f64> = map.pixels.iter().map(luminance).filter(|&value| value > 0.0).collect();
    lit.sort_by(f64::total_cmp);
    let mean = libm::exp(lit.iter().map(|&value| libm::log(value)).sum::<f64>() / lit.len().max(1) as f64);
    let scale = 0.18 / mean;
    let white = scale * lit.get(lit.len() * 998 / 1000).copied().unwrap_or(1.0);
    let white = white.max(1.0);
    let tone = |pixel: &[f32; 3]| {
        let scaled = scale * luminance(pixel);
        let shown = (1.0 + scaled / (white * white)) / (1.0 + scaled);
        pixel.map(|value| encode(f64::from(value) * scale * shown))
    };
    map.pixels.iter().map(tone).collect()
}

/// sRGB's transfer curve (IEC 61966-2-1), to 8 bits.
fn encode(linear: f64) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let value = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 };
    (value * 255.0).round() as u8
}
