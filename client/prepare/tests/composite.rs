//! What of a background's edges is seen through a part.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_prepare::composite::{Method, Place, Sprite, composite};
use gonio_scene::image::Image;

fn checks() -> Image {
    let pixels = (0..320 * 200).map(|k| [if (k % 320 / 10 + k / 320 / 10) % 2 == 0 { 0.9 } else { 0.1 }; 3]);
    Image { width: 320, height: 200, pixels: pixels.collect() }
}

/// A glossy pane that lets 40 % through.
fn pane() -> Sprite {
    Sprite { width: 120, height: 100, pixels: vec![[0.3, 0.25, 0.2, 0.6]; 120 * 100] }
}

/// Mean squared difference of neighbours in the pane's interior.
fn edge_energy(image: &Image) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for y in 60..140 {
        for x in 110..210 {
            let at = |x: usize, y: usize| f64::from(image.pixels[y * 320 + x][1]);
            sum += (at(x + 1, y) - at(x, y)).powi(2) + (at(x, y + 1) - at(x, y)).powi(2);
            count += 2.0;
        }
    }
    sum / count
}

#[test]
fn edges_are_not_seen_through_a_glossy_part_with_blur_and_are_without() {
    let background = checks();
    let drawn = |method| {
        let mut picture = background.clone();
        composite(&mut picture, &pane(), Place { column: 100, row: 50 }, method);
        picture
    };
    let [blur, alpha, binary] = [Method::AlphaBlur, Method::Alpha, Method::Binary].map(drawn);
    let bare = edge_energy(&background);
    let [with, without] = [&blur, &alpha].map(|image| edge_energy(image) / bare);
    println!("edge energy: blur {with:.5}, alpha {without:.5} of the bare background's");
    assert!((without - 0.16).abs() < 0.001 && with < 0.02 * without);
    assert!(edge_energy(&binary) == 0.0);
    for k in [0, 320 * 49 + 150, 320 * 100 + 99, 320 * 150 + 150] {
        assert_eq!(blur.pixels[k], background.pixels[k]);
    }
}

#[test]
fn a_part_that_leaves_the_picture_is_clipped_and_scaling_keeps_its_mean() {
    let mut picture = checks();
    for (column, row) in [(-60, -50), (300, 180), (1000, 0), (0, -1000), (i64::MAX, i64::MIN)] {
        composite(&mut picture, &pane(), Place { column, row }, Method::AlphaBlur);
    }
    assert!(picture.pixels.iter().flatten().all(|value| value.is_finite()));
    for scale in [0.13, 0.5, 1.0, 2.7] {
        let scaled = pane().scaled(scale);
        assert_eq!(scaled.width, (120.0 * scale).round() as usize);
        assert!(scaled.pixels.iter().all(|pixel| (pixel[3] - 0.6).abs() < 1e-5));
    }
    assert!(Sprite::decode("v.png", b"no image").unwrap_err().to_string().contains("v.png"));
}
