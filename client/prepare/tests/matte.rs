//! Mattes of generated scenes with known alpha, and of photographs.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_prepare::matte::{Backed, Depth, Shadows, encode, matte};
use gonio_prepare::stored;
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::Image;
use std::path::PathBuf;

const SIZE: [usize; 2] = [200, 150];

fn noise(k: usize, c: usize, shot: usize) -> f64 {
    let mut sum = -6.0;
    for n in 0..12_u64 {
        let mut x = (k as u64 * 64 + c as u64 * 16 + n).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (shot as u64 + 1) << 40;
        x = (x ^ (x >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        sum += ((x ^ (x >> 32)) >> 11) as f64 / (1_u64 << 53) as f64;
    }
    sum
}

fn image_of(pixel: impl Fn(usize, usize) -> [f64; 3], shot: usize) -> Image {
    let [width, height] = SIZE;
    let pixels = (0..width * height)
        .map(|k| {
            let value = pixel(k % width, k / width);
            std::array::from_fn(|c| {
                ((255.0 * value[c] + 0.7 * noise(k, c, shot)).round().clamp(0.0, 255.0) / 255.0) as f32
            })
        })
        .collect();
    Image { width: width as u32, height: height as u32, pixels }
}

/// Coverage 0..1 of a disc with an antialiased border.
fn disc(x: usize, y: usize, centre: [f64; 2], radius: f64) -> f64 {
    let (dx, dy) = (x as f64 - centre[0], y as f64 - centre[1]);
    (radius + 0.5 - (dx * dx + dy * dy).sqrt()).clamp(0.0, 1.0)
}

/// Alpha and colour: an opaque ball in a backdrop's own colour with a highlight, hairs of a third of a pixel, a glass pane.
fn object(x: usize, y: usize) -> (f64, [f64; 3]) {
    let ball = disc(x, y, [60.0, 70.0], 30.0);
    let pane = if (110..170).contains(&x) && (30..100).contains(&y) { 0.35 } else { 0.0 };
    let hair = if y < 28 && x % 7 == 3 && x > 20 && x < 180 { 0.33 } else { 0.0 };
    if ball > 0.0 {
        let shine = disc(x, y, [50.0, 58.0], 6.0);
        (ball, [0.1 + 0.9 * shine, 0.2 + 0.8 * shine, 0.8 + 0.2 * shine])
    } else if pane > 0.0 {
        (pane, [0.7, 0.9, 0.8])
    } else {
        (hair, [0.45, 0.3, 0.15])
    }
}

fn backed(shadow: bool, gain: [f64; 3]) -> [Backed; 2] {
    let plates: [[f64; 3]; 2] = [[0.1, 0.2, 0.8], [0.2, 0.75, 0.25]];
    let plate = |side: usize, x: usize, y: usize| {
        let shade = 1.0 - 0.1 * ((x as f64 - 100.0) / 100.0).powi(2) - 0.05 * y as f64 / 150.0;
        plates[side].map(|value| value * shade)
    };
    let on = |side: usize, x: usize, y: usize| {
        let (alpha, colour) = object(x, y);
        let dark = if shadow { 1.0 - 0.4 * disc(x, y, [60.0, 122.0], 18.0) } else { 1.0 };
        let back = plate(side, x, y);
        let seen: [f64; 3] = std::array::from_fn(|c| alpha * colour[c] + (1.0 - alpha) * back[c] * dark);
        if side == 1 { std::array::from_fn(|c| seen[c] * gain[c]) } else { seen }
    };
    [0, 1].map(|side| Backed {
        name: format!("on{side}.png"),
        on: image_of(|x, y| on(side, x, y), side),
        plate_name: format!("plate{side}.png"),
        plate: image_of(|x, y| plate(side, x, y), side + 2),
    })
}

/// Mean errors of the matte and of its binary version.
fn errors(backed: &[Backed; 2]) -> (f64, f64) {
    let found = matte(backed, Shadows::Remove).unwrap();
    let mut binary = found.clone();
    binary.harden();
    let truth = |k: usize| object(k % SIZE[0], k / SIZE[0]).0;
    let error = |alpha: &[f32]| {
        alpha.iter().enumerate().map(|(k, &a)| (f64::from(a) - truth(k)).abs()).sum::<f64>() / alpha.len() as f64
    };
    println!(
        "matte {:.5} binary {:.5} shadow {} {:?}",
        error(&found.alpha),
        error(&binary.alpha),
        found.shadow,
        found.drift
    );
    (error(&found.alpha), error(&binary.alpha))
}

#[test]
fn alpha_is_found_with_shadow_and_drift() {
    for (shadow, gain) in [(false, [1.0; 3]), (true, [1.0; 3]), (false, [0.88, 1.04, 1.2]), (true, [0.9, 1.0, 1.1])] {
        let (found, binary) = errors(&backed(shadow, gain));
        assert!(found < 0.01 && 3.0 * found < binary, "{found} {binary}");
    }
}

#[test]
fn the_foreground_is_unmixed_and_sixteen_bits_are_written() {
    let found = matte(&backed(true, [1.0; 3]), Shadows::Remove).unwrap();
    let k = 60 * SIZE[0] + 140;
    for (value, truth) in found.colour.pixels[k].iter().zip([0.7, 0.9, 0.8]) {
        assert!((value - truth).abs() < 0.03, "{value} {truth}");
    }
    let bytes = encode("m.png", &found, Depth::Sixteen).unwrap();
    assert_eq!(bytes[24], 16);
    assert_eq!(encode("m.png", &found, Depth::Eight).unwrap()[24..26], [8, 6]);
}

#[test]
fn backdrops_that_do_not_fit_are_refused_by_name() {
    let good = backed(false, [1.0; 3]);
    let refusal = |backed: &[Backed; 2]| matte(backed, Shadows::Remove).unwrap_err().to_string();
    let mut swapped = good.clone();
    let [a, b] = &mut swapped;
    std::mem::swap(&mut a.plate, &mut b.plate);
    assert!(refusal(&swapped).contains("on0.png"));
    let alike = [good[0].clone(), good[0].clone()];
    assert!(refusal(&alike).contains("plate0.png"));
    let mut small = good;
    small[1].plate = Image { width: 2, height: 1, pixels: vec![[0.0; 3]; 2] };
    assert!(refusal(&small).contains("plate1.png"));
}

#[test]
fn a_published_matte_is_found_again() {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    let folder = std::env::var_os("GONIO_REAL").map_or_else(beside, PathBuf::from).join("matting-flowers");
    if !folder.is_dir() {
        println!("skipped: no matting-flowers in GONIO_REAL or ../shared/real");
        return;
    }
    let files = DirectoryFiles::new(&folder);
    // The published matte lies as the photos are stored, and states no orientation, which they do.
    let read = |name: &str| stored::read(&files, &format!("flowers-{name}.jpg")).unwrap().0;
    let pair = ["A", "B"].map(|side| Backed {
        name: format!("comp{side}"),
        on: read(&format!("comp{side}")),
        plate_name: format!("back{side}"),
        plate: read(&format!("back{side}")),
    });
    let published = read("alpha");
    let [kept, removed] = [Shadows::Keep, Shadows::Remove].map(|shadows| matte(&pair, shadows).unwrap());
    // The published method has no notion of a shadow: there the two differ by intent.
    let shadow = |k: usize| kept.alpha[k] > 0.0 && removed.alpha[k] == 0.0;
    let mean = |alpha: &[f32], use_it: &dyn Fn(usize) -> bool| {
        let differences = (0..alpha.len()).filter(|&k| use_it(k)).map(|k| (alpha[k] - published.pixels[k][0]).abs());
        let (sum, count) = differences.fold((0.0, 0), |(sum, count), off| (sum + f64::from(off), count + 1));
        sum / f64::from(count)
    };
    let lit = mean(&removed.alpha, &|k| !shadow(k));
    let (all_kept, all_removed) = (mean(&kept.alpha, &|_| true), mean(&removed.alpha, &|_| true));
    println!(
        "flowers: {lit:.5} off the shadow; with it {all_kept:.5} kept, {all_removed:.5} removed; {:?}",
        kept.drift
    );
    if let Some(out) = std::env::var_os("GONIO_TEST_OUT") {
        std::fs::write(PathBuf::from(out).join("flowers.png"), encode("flowers", &removed, Depth::Eight).unwrap())
            .unwrap();
    }
    assert!(lit < 0.01 && all_kept < 0.01, "{lit} {all_kept}");
}
