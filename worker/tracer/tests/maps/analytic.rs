//! A diffuse square under an even sky shows its own colour times the sky, nothing else.

use crate::fixture::{SIDE, SKY, World, distance, exr, square};

const BASE: [f64; 3] = [0.8, 0.6, 0.4];

fn lambert(map: &str) -> String {
    format!("model = \"lambert\"\nbase_color = {BASE:?}\nbase_color_map = \"{map}\"\n")
}

/// What a map of these values shows.
fn shown(map: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| BASE[c] * map[c] * SKY[c])
}

/// Colours that are linear over the square are so in the photo: pixel (x, y) has the value at its middle.
#[test]
fn vertex_colours_are_linear_over_the_square() {
    let corner = |x: f32, y: f32| [0.2 + 0.6 * x, 0.9 - 0.5 * y, 0.5];
    // As the square's corners go: y up.
    let world = World::new(
        &lambert("mesh"),
        square(Some([corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0), corner(0.0, 0.0)])),
    );
    for (k, found) in world.render(64).into_iter().enumerate() {
        let at = |k: u32| (f64::from(k) + 0.5) / f64::from(SIDE);
        let (x, y) = (at(k as u32 % SIDE), at(k as u32 / SIDE));
        let expected = shown([0.2 + 0.6 * x, 0.9 - 0.5 * y, 0.5]);
        for c in 0..3 {
            assert!((found[c] / expected[c] - 1.0).abs() < 0.01, "pixel {k}: {found:?} for {expected:?}");
        }
    }
}

/// Each texel of a checker of 8 x 8 covers 3 x 3 pixels. Over the middle one, as values are linear between texels' middles, a
/// neighbour has the mean weight 1/12 along each axis: so much of the pixel is of the other kind.
#[test]
fn texels_lie_where_they_belong_and_are_linear_between() {
    let mut world = World::new(&lambert("checker.exr"), square(None));
    let value = |x: u32, y: u32| {
        if x == 0 && y == 1 {
            // One texel of another colour says which way is up and right.
            [0.0, 0.0, 0.9]
        } else if (x + y).is_multiple_of(2) {
            [0.9, 0.2, 0.5]
        } else {
            [0.1, 0.8, 0.5]
        }
    };
    world.add("checker.exr", exr(8, 8, value));
    let render = world.render(256);
    let share = 1.0 / 12.0;
    let weights = [share / 2.0, 1.0 - share, share / 2.0];
    for y in 0..8u32 {
        for x in 0..8u32 {
            let found = render[((3 * y + 1) * SIDE + 3 * x + 1) as usize];
            let mut map = [0.0; 3];
            for (i, down) in weights.iter().enumerate() {
                for (j, right) in weights.iter().enumerate() {
                    let texel = value((x + 7 + j as u32) % 8, (y + 7 + i as u32) % 8);
                    (0..3).for_each(|c| map[c] += down * right * f64::from(texel[c]));
                }
            }
            let expected = shown(map);
            for c in 0..3 {
                assert!((found[c] - expected[c]).abs() < 0.02, "({x}, {y}): {found:?} for {expected:?}");
            }
        }
    }
}

/// 512 x 512 texels over 24 x 24 pixels: single texels would leave a noise of a tenth at so few samples.
#[test]
fn a_fine_checker_shows_its_mean() {
    let mut world = World::new(&lambert("fine.exr"), square(None));
    world.add("fine.exr", exr(512, 512, |x, y| [if (x + y).is_multiple_of(2) { 1.0 } else { 0.25 }; 3]));
    let expected = shown([0.625; 3]);
    for found in world.render(8) {
        for c in 0..3 {
            assert!((found[c] / expected[c] - 1.0).abs() < 0.01, "{found:?} for {expected:?}");
        }
    }
}

/// sRGB's middle gray 188 is 0.5029 linear (IEC 61966-2-1); a gray of 16 bits is the same three times.
#[test]
fn integers_are_srgb_and_gray_is_three_channels() {
    let mut world = World::new(&lambert("gray.png"), square(None));
    let gray16: Vec<u8> = [188u16 * 257; 4].iter().flat_map(|v| v.to_be_bytes()).collect();
    world.add("gray.png", png(&gray16));
    let expected = shown([0.502_886; 3]);
    for found in world.render(2) {
        for c in 0..3 {
            assert!((found[c] / expected[c] - 1.0).abs() < 1e-4, "{found:?} for {expected:?}");
        }
    }
}

/// A PNG of 2 x 2 gray pixels of 16 bits: stored, not compressed.
fn png(samples: &[u8]) -> Vec<u8> {
    let rows: Vec<u8> = samples.chunks(4).flat_map(|row| [&[0], row].concat()).collect();
    let adler = rows.iter().fold((1u32, 0u32), |(a, b), v| {
        let a = (a + u32::from(*v)) % 65521;
        (a, (b + a) % 65521)
    });
    let length = rows.len() as u16;
    let stored = [&[0x78, 1, 1][..], &length.to_le_bytes(), &(!length).to_le_bytes(), &rows].concat();
    let data = [stored, (adler.1 << 16 | adler.0).to_be_bytes().to_vec()].concat();
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let header = [&2u32.to_be_bytes()[..], &2u32.to_be_bytes(), &[16, 0, 0, 0, 0]].concat();
    for (name, content) in [(b"IHDR", header), (b"IDAT", data), (b"IEND", vec![])] {
        let chunk = [&name[..], &content].concat();
        let crc = chunk.iter().fold(!0u32, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
        });
        out.extend((content.len() as u32).to_be_bytes());
        out.extend(chunk);
        out.extend((!crc).to_be_bytes());
    }
    out
}

/// A map that is the same everywhere is the number times it: the number alone is a render of another code path.
#[test]
fn even_maps_are_factors_on_colour_roughness_and_metallic() {
    let lamp = "[[light]]\nname = \"led\"\nkind = \"sphere\"\nposition = [0.3, 0.2, 0.6]\nradius = 0.2\n\
                intensity = [1, 1, 1]\n";
    let plastic = |color: [f64; 3], roughness: f64, metallic: f64, more: &str| {
        format!(
            "model = \"plastic\"\nbase_color = {color:?}\nroughness = {roughness}\nior = 1.5\nmetallic = {metallic}\n{more}"
        )
    };
    let maps = "base_color_map = \"c.exr\"\nroughness_map = \"r.exr\"\nmetallic_map = \"m.exr\"\n";
    let mut mapped = World::new(&plastic([0.8, 0.5, 1.0], 0.5, 0.4, maps), square(None));
    mapped.lights.push_str(lamp);
    mapped.add("c.exr", exr(2, 2, |_, _| [0.25, 0.8, 0.5]));
    // Green is roughness, blue metallic; the others count for nothing.
    mapped.add("r.exr", exr(2, 2, |_, _| [0.0, 0.8, 1.0]));
    mapped.add("m.exr", exr(2, 2, |_, _| [1.0, 0.0, 0.5]));
    let mut plain = World::new(&plastic([0.2, 0.4, 0.5], 0.4, 0.2, ""), square(None));
    plain.lights.push_str(lamp);
    let error = distance(&mapped.render(64), &plain.render(64));
    // The boundary's table between its rungs is right to 1e-3.
    assert!(error < 2e-3, "{error}");
    let other = World { material: plastic([0.2, 0.4, 0.5], 0.5, 0.2, ""), ..plain };
    assert!(distance(&mapped.render(64), &other.render(64)) > 0.01);
}
