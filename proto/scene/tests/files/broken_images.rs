//! Every broken image and mask gets an error that names its file and what to do.

use ::image::ExtendedColorType;
use exr::prelude::{Compression, FlatSamples};
use gonio_scene::image::{self as images, Image, encode_exr};

use crate::files;
use crate::fixture_images::{HEIGHT, WIDTH, bytes8, channel, exr, hdr, jpeg, layer, plain_exr, png, tiff, values};

const SIZE: (usize, usize) = (WIDTH as usize, HEIGHT as usize);

fn check(error: &gonio_scene::SceneError, name: &str, says: &str) {
    let line = error.to_string();
    assert!(error.file == name && line.starts_with(name), "{line}");
    assert!(!error.mend.is_empty() && !line.contains('\n'), "{line}");
    assert!(line.contains(says), "expected {says:?} in: {line}");
}

fn refused(name: &str, bytes: &[u8], says: &str) {
    check(&images::read(&files(&[(name, bytes)]), name).expect_err(says), name, says);
}

/// Refused from the header alone.
fn refused_early(name: &str, bytes: &[u8], says: &str) {
    refused(name, bytes, says);
    check(&images::dimensions(&files(&[(name, bytes)]), name).expect_err(says), name, says);
}

fn refused_mask(name: &str, bytes: &[u8], says: &str) {
    check(&images::read_mask(&files(&[(name, bytes)]), name).expect_err(says), name, says);
}

fn colour_png() -> Vec<u8> {
    png(&bytes8(3), ExtendedColorType::Rgb8)
}

fn one_layer(channels: Vec<(&str, FlatSamples)>) -> Vec<u8> {
    exr((0, 0), vec![layer("main", (0, 0), SIZE, channels, Compression::ZIP16)])
}

#[test]
fn files_that_are_something_else() {
    refused_early("a.png", b"", "is empty");
    refused_early("a.gif", b"GIF89a", "extension");
    refused_early("a.png", b"GIF89a", "does not begin as a Png");
    refused_early("a.jpg", &colour_png(), "is a Png file");
    refused_early("a.exr", &hdr(&values()), "is a Hdr file");
    refused_early("a.png", &plain_exr(Compression::ZIP16), "is a OpenExr file");
    assert!(images::read(&files(&[]), "nowhere.exr").unwrap_err().to_string().contains("nowhere.exr"));
}

#[test]
fn truncated_files() {
    let rgb = ExtendedColorType::Rgb8;
    for (name, bytes) in [
        ("a.png", colour_png()),
        ("a.tif", tiff(&bytes8(3), rgb)),
        ("a.jpg", jpeg(&bytes8(3), rgb)),
        ("a.hdr", hdr(&values())),
        ("a.exr", plain_exr(Compression::ZIP16)),
        ("a.exr", plain_exr(Compression::Uncompressed)),
    ] {
        assert!(images::read(&files(&[(name, &bytes)]), name).is_ok(), "{name}");
        for kept in [8, bytes.len() / 4, bytes.len() / 2, bytes.len() * 3 / 4, bytes.len() - 20] {
            refused(name, &bytes[..kept], "");
        }
    }
}

#[test]
fn sizes_that_no_image_has() {
    let sized = |width: u32, height: u32| {
        // Without its checksum the header would be refused for that alone.
        let mut bytes = crate::fixture_images::png_of_one_bit(&[0; 5]);
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        let checksum = crate::fixture_images::crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
        bytes
    };
    refused_early("a.png", &sized(0, 5), "a.png");
    refused_early("a.png", &sized(20_000, 5), "above the limit of 16384");
    refused_early("a.png", &sized(16_000, 16_000), "above the limit of 1073741824");
    refused_early("a.png", &sized(8_000, 8_000), "cannot hold");
    refused_early("a.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 9000 +X 9000\n", "cannot hold");
    refused_early("a.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99999 +X 9\n", "above the limit");

    let mut window = plain_exr(Compression::ZIP16);
    let name = b"dataWindow\0box2i\0";
    let at = window.windows(name.len()).position(|found| found == name).unwrap() + name.len() + 4;
    window[at + 8..at + 12].copy_from_slice(&9000i32.to_le_bytes());
    window[at + 12..at + 16].copy_from_slice(&9000i32.to_le_bytes());
    refused("a.exr", &window, "a.exr");
    window[at + 8..at + 12].copy_from_slice(&i32::MAX.to_le_bytes());
    refused("a.exr", &window, "a.exr");
    window[at + 8..at + 12].copy_from_slice(&(-5i32).to_le_bytes());
    refused("a.exr", &window, "a.exr");
}

#[test]
fn pixels_that_are_not_finite() {
    for (value, name) in [(f32::NAN, "a.exr"), (f32::INFINITY, "a.exr"), (f32::NEG_INFINITY, "a.exr")] {
        let mut pixels = values();
        pixels[16][1] = value;
        pixels[20][2] = value;
        let image = Image { width: WIDTH, height: HEIGHT, pixels };
        refused(name, &encode_exr(name, &image).unwrap(), "pixel (column 2, row 2): has 2 pixels");
    }
    let mut samples: Vec<f32> = values().into_iter().flatten().collect();
    samples[0] = f32::NAN;
    let samples: Vec<u8> = samples.iter().flat_map(|value| value.to_ne_bytes()).collect();
    refused("a.tif", &tiff(&samples, ExtendedColorType::Rgb32F), "pixel (column 0, row 0): has 1 pixels");
}

#[test]
fn exr_without_one_colour() {
    refused(
        "a.exr",
        &one_layer(vec![("X", channel(0)), ("Z", channel(1))]),
        "no unambiguous colour among its channels X, Z",
    );
    refused("a.exr", &one_layer(vec![("R", channel(0)), ("G", channel(1))]), "no unambiguous colour");
    refused(
        "a.exr",
        &one_layer(vec![("Y", channel(0)), ("RY", channel(1)), ("BY", channel(1))]),
        "no unambiguous colour",
    );
    let mut two = Vec::new();
    for (name, index) in [("a.R", 0), ("a.G", 1), ("a.B", 2), ("b.R", 0), ("b.G", 1), ("b.B", 2)] {
        two.push((name, channel(index)));
    }
    refused("a.exr", &one_layer(two), "no unambiguous colour");
}

#[test]
fn exr_that_is_cropped() {
    let channels = || vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
    for position in [(1, 0), (0, -1), (100, 100)] {
        let bytes = exr((0, 0), vec![layer("main", position, SIZE, channels(), Compression::ZIP16)]);
        refused("a.exr", &bytes, "dataWindow: has pixels only in 7 x 5 at");
    }
}

#[test]
fn masks() {
    let gray = ExtendedColorType::L8;
    refused_mask("m.png", &png(&[1; 35], gray), "the largest value 1 of 255");
    refused_mask("m.png", &png(&[127; 35], gray), "the largest value 127 of 255");
    refused_mask("m.png", &colour_png(), "pixel (column 0, row 0): has a colour");
    let mut late = vec![255; 105];
    late[3 * 9] = 0;
    refused_mask("m.png", &png(&late, ExtendedColorType::Rgb8), "pixel (column 2, row 1): has a colour");
    refused_mask("m.exr", &plain_exr(Compression::ZIP16), "floating-point values");
    refused_mask("m.hdr", &hdr(&values()), "floating-point values");
    let samples: Vec<u8> = values().iter().flatten().flat_map(|value| value.to_ne_bytes()).collect();
    refused_mask("m.tif", &tiff(&samples, ExtendedColorType::Rgb32F), "a pixel type that a mask cannot have");
    let whole = png(&[255; 35], gray);
    refused_mask("m.png", &whole[..whole.len() - 20], "m.png");
    refused_mask("m.txt", &whole, "extension");
}
