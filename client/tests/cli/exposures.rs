//! A camera with a known response and known noise, and what it makes of radiance.

use gonio_scene::image::{Image, write_png8};
use std::path::Path;

/// The camera's exposed light at code 128: there `gonio hdr` sets its unit.
pub const UNIT: f64 = 0.308_1;

/// The camera's curve, a gamma with a shoulder: exposed light to a file's value, above 1 where it is clipped.
pub fn curve(exposed: f64) -> f64 {
    1.02 * (1.0 - (-0.9 * exposed).exp()).max(0.0).sqrt()
}

/// The code of a value, with `noise` codes of normally distributed noise that follow from `seed`.
pub fn code(value: f64, noise: f64, seed: u64) -> u8 {
    (255.0 * value + noise * normal(seed)).round().clamp(0.0, 255.0) as u8
}

/// Writes a photo of `radiance` at `exposure`.
pub fn photograph(file: &Path, radiance: &Image, exposure: f64, noise: f64, seed: u64) {
    let pixels: Vec<[u8; 3]> = radiance
        .pixels
        .iter()
        .zip(0_u64..)
        .map(|(light, k)| {
            [0, 1, 2].map(|c| code(curve(f64::from(light[c]) * exposure), noise, (seed << 40) + 3 * k + c as u64))
        })
        .collect();
    write_png8(file, radiance.width, radiance.height, &pixels).unwrap();
}

/// Writes a stack of photos `0.png` and so on, and their list `times.csv`; returns the photos' names.
pub fn stack(folder: &Path, radiance: &Image, seconds: &[f64]) -> Vec<String> {
    let mut list = "file,seconds\n".to_owned();
    let mut names = Vec::new();
    for (k, &seconds) in seconds.iter().enumerate() {
        let name = format!("{k}.png");
        photograph(&folder.join(&name), radiance, seconds, 0.8, k as u64 + 1);
        list += &format!("{name},{seconds}\n");
        names.push(name);
    }
    std::fs::write(folder.join("times.csv"), list).unwrap();
    names
}

/// A sky with a small sun and a dark ground, over twelve stops; equirectangular.
pub fn sky(width: u32) -> Image {
    let height = width / 2;
    let pixel = |k: u32| {
        let azimuth = (f64::from(k % width) + 0.5) / f64::from(width) * std::f64::consts::TAU;
        let elevation = 0.5 - (f64::from(k / width) + 0.5) / f64::from(height);
        let ground = if elevation < 0.0 { 0.02 + 0.1 * (1.0 + azimuth.cos()) } else { 0.0 };
        let above = if elevation >= 0.0 { 0.3 + 1.5 * elevation + 0.5 * azimuth.sin() } else { 0.0 };
        let (dx, dy) = ((azimuth - 2.2) * elevation.mul_add(-1.0, 1.0), 3.0 * (elevation - 0.28));
        let sun = 60.0 * (-(dx * dx + dy * dy) / 0.03).exp();
        [1.0, 0.95, 0.8].map(|tint| ((ground + above.max(0.0)) * (2.0 - tint) + sun * tint) as f32)
    };
    Image { width, height, pixels: (0..width * height).map(pixel).collect() }
}

/// Normally distributed, by the sum of twelve.
fn normal(seed: u64) -> f64 {
    let uniform = |k: u64| {
        let mut x = (12 * seed + k).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..12).map(uniform).sum::<f64>() - 6.0
}
