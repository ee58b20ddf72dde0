//! What each image format's files give.

use ::image::ExtendedColorType;
use exr::prelude::{Compression, FlatSamples, f16};
use gonio_scene::image::{self as images, Image, Mask, encode_exr, encode_exr_channels, encode_png8};

use crate::files;
use crate::fixture_images::{
    HEIGHT, WIDTH, bytes8, channel, exr, hdr, jpeg, layer, native, plain_exr, png, png_of_one_bit, tiff, values,
    words16,
};

const SIZE: (usize, usize) = (WIDTH as usize, HEIGHT as usize);

fn read(name: &str, bytes: &[u8]) -> Image {
    let files = files(&[(name, bytes)]);
    let image = images::read(&files, name).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(images::dimensions(&files, name).unwrap(), (image.width, image.height));
    image
}

fn pixels(name: &str, bytes: &[u8]) -> Vec<[f32; 3]> {
    let image = read(name, bytes);
    assert_eq!((image.width, image.height), (WIDTH, HEIGHT));
    image.pixels
}

/// The colour of samples that lie as `channels` per pixel.
fn colour<T: Copy>(samples: &[T], channels: usize, value: impl Fn(T) -> f32) -> Vec<[f32; 3]> {
    let pixel =
        |pixel: &[T]| if channels < 3 { [value(pixel[0]); 3] } else { [0, 1, 2].map(|index| value(pixel[index])) };
    samples.chunks(channels).map(pixel).collect()
}

#[test]
fn png_and_tiff_of_8_and_16_bits() {
    let eight = [ExtendedColorType::L8, ExtendedColorType::La8, ExtendedColorType::Rgb8, ExtendedColorType::Rgba8];
    let sixteen =
        [ExtendedColorType::L16, ExtendedColorType::La16, ExtendedColorType::Rgb16, ExtendedColorType::Rgba16];
    for channels in 1..=4 {
        let samples = bytes8(channels);
        let expected = colour(&samples, channels, |value| f32::from(value) / 255.0);
        assert_eq!(pixels("a.png", &png(&samples, eight[channels - 1])), expected);
        let words = words16(channels);
        let expected_words = colour(&words, channels, |value| f32::from(value) / 65535.0);
        assert_eq!(pixels("a.png", &png(&native(&words), sixteen[channels - 1])), expected_words);
        // The TIFF encoder knows no gray with alpha.
        if channels != 2 {
            assert_eq!(pixels("a.tiff", &tiff(&samples, eight[channels - 1])), expected);
            assert_eq!(pixels("a.tif", &tiff(&native(&words), sixteen[channels - 1])), expected_words);
        }
    }
    assert_eq!(pixels("a.png", &png(&[255; 35], ExtendedColorType::L8)), vec![[1.0; 3]; 35]);
}

#[test]
fn tiff_of_floats() {
    let samples: Vec<u8> = values().iter().flatten().flat_map(|value| value.to_ne_bytes()).collect();
    assert_eq!(pixels("a.tif", &tiff(&samples, ExtendedColorType::Rgb32F)), values());
}

#[test]
fn jpeg_of_gray_and_colour() {
    let flat: Vec<u8> = [200, 100, 50].repeat(35);
    for found in pixels("a.JPG", &jpeg(&flat, ExtendedColorType::Rgb8)) {
        assert!(found.iter().zip([200.0, 100.0, 50.0]).all(|(a, b)| (a * 255.0 - b).abs() < 3.0), "{found:?}");
    }
    let gray = pixels("a.jpeg", &jpeg(&[128; 35], ExtendedColorType::L8));
    assert!(gray.iter().all(|pixel| pixel[0] == pixel[2] && (pixel[0] * 255.0 - 128.0).abs() < 2.0));
}

#[test]
fn hdr_within_its_own_precision() {
    for (found, expected) in pixels("a.hdr", &hdr(&values())).iter().zip(values()) {
        // One exponent for three mantissas of eight bits.
        let step = expected.iter().fold(0.0, |a: f32, &b| a.max(b)) / 128.0;
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= step), "{found:?} {expected:?}");
    }
}

#[test]
fn exr_of_every_compression() {
    for compression in
        [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ]
    {
        assert_eq!(pixels("a.exr", &plain_exr(compression)), values(), "{compression:?}");
    }
    for compression in [Compression::PXR24, Compression::DWAA(None), Compression::DWAB(None)] {
        for (found, expected) in pixels("a.exr", &plain_exr(compression)).iter().zip(values()) {
            assert!(
                found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 0.02 * b + 1e-3),
                "{compression:?} {found:?}"
            );
        }
    }
}

#[test]
fn exr_of_every_sample_type() {
    let half = FlatSamples::F16(values().iter().map(|pixel| f16::from_f32(pixel[0])).collect());
    let whole = FlatSamples::U32((0..35).collect());
    let bytes = exr(
        (0, 0),
        vec![layer("main", (0, 0), SIZE, vec![("R", half), ("G", whole), ("B", channel(2))], Compression::ZIP16)],
    );
    for (index, (found, expected)) in pixels("a.exr", &bytes).iter().zip(values()).enumerate() {
        assert_eq!(*found, [f16::from_f32(expected[0]).to_f32(), index as f32, expected[2]]);
    }
}

#[test]
fn exr_finds_the_colour_among_other_channels() {
    let one = |channels: Vec<(&str, FlatSamples)>| {
        exr((0, 0), vec![layer("main", (0, 0), SIZE, channels, Compression::ZIP16)])
    };
    let gray: Vec<_> = values().iter().map(|pixel| [pixel[1]; 3]).collect();
    let rgb = |prefix: &'static str| {
        let name = |channel| &*format!("{prefix}{channel}").leak();
        vec![(name("R"), channel(0)), (name("G"), channel(1)), (name("B"), channel(2))]
    };
    let with = |mut channels: Vec<(&'static str, FlatSamples)>, more: &[(&'static str, FlatSamples)]| {
        channels.extend_from_slice(more);
        channels
    };
    let depth = FlatSamples::F32(vec![f32::INFINITY; 35]);
    assert_eq!(pixels("a.exr", &one(with(rgb(""), &[("A", depth.clone()), ("Z", depth.clone())]))), values());
    assert_eq!(pixels("a.exr", &one(with(rgb("beauty."), &[("depth.Z", depth.clone())]))), values());
    let main_and_other = with(rgb(""), &[("other.R", channel(1)), ("other.G", channel(1)), ("other.B", channel(1))]);
    assert_eq!(pixels("a.exr", &one(main_and_other)), values());
    assert_eq!(pixels("a.exr", &one(vec![("Y", channel(1)), ("A", depth.clone())])), gray);
    assert_eq!(pixels("a.exr", &one(vec![("anything", channel(1))])), gray);

    let parts = vec![
        layer("depth", (0, 0), SIZE, vec![("Z", depth)], Compression::ZIP16),
        layer("colour", (0, 0), SIZE, rgb(""), Compression::RLE),
    ];
    assert_eq!(pixels("a.exr", &exr((0, 0), parts)), values());
}

#[test]
fn exr_gives_its_display_window() {
    // A window that does not start at zero, and one with pixels around it.
    let channels = vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
    assert_eq!(
        pixels("a.exr", &exr((-3, 9), vec![layer("main", (-3, 9), SIZE, channels, Compression::ZIP16)])),
        values()
    );

    let (wide, high) = (SIZE.0 + 4, SIZE.1 + 3);
    let around = |index: usize| {
        let value = |i: usize| match ((i % wide).checked_sub(3), (i / wide).checked_sub(1)) {
            (Some(x), Some(y)) if x < SIZE.0 && y < SIZE.1 => values()[y * SIZE.0 + x][index],
            _ => -1.0,
        };
        FlatSamples::F32((0..wide * high).map(value).collect())
    };
    let channels = vec![("R", around(0)), ("G", around(1)), ("B", around(2))];
    let overscan = exr((0, 0), vec![layer("main", (-3, -1), (wide, high), channels, Compression::ZIP16)]);
    assert_eq!(pixels("a.exr", &overscan), values());
}

#[test]
fn written_exr_keeps_every_bit() {
    let mut pixels = values();
    pixels[3] = [f32::MIN_POSITIVE / 8.0, -0.0, f32::MAX];
    let image = Image { width: WIDTH, height: HEIGHT, pixels };
    let bytes = encode_exr("a.exr", &image).unwrap();
    assert_eq!(encode_exr("a.exr", &image).unwrap(), bytes);
    let bits = |image: &Image| image.pixels.iter().flatten().map(|value| value.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&read("a.exr", &bytes)), bits(&image));

    let folder = tempfile::tempdir().unwrap();
    images::write_exr(&folder.path().join("a.exr"), &image).unwrap();
    assert_eq!(std::fs::read(folder.path().join("a.exr")).unwrap(), bytes);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left behind");
}

#[test]
fn large_images_of_one_value_are_read_though_they_compress_well() {
    let (width, height) = (1024, 768);
    let image = Image { width, height, pixels: vec![[0.0; 3]; 1024 * 768] };
    assert_eq!(read("a.exr", &encode_exr("a.exr", &image).unwrap()), image);
    let png = encode_png8("a.png", width, height, &vec![[0; 3]; 1024 * 768]).unwrap();
    assert_eq!(read("a.png", &png), image);
    let jpeg_of = |side: usize| {
        let mut bytes = Vec::new();
        let encoder = ::image::codecs::jpeg::JpegEncoder::new(&mut bytes);
        let black = vec![0; side * side];
        ::image::ImageEncoder::write_image(encoder, &black, side as u32, side as u32, ExtendedColorType::L8).unwrap();
        bytes
    };
    assert_eq!(read("a.jpg", &jpeg_of(1024)).pixels.len(), 1024 * 1024);
}

#[test]
fn written_channels_come_back_by_name() {
    use exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("buffers.exr");
    let depth: Vec<f32> = (0..35).map(|i| i as f32).collect();
    let missed = vec![f32::INFINITY; 35];
    images::write_exr_channels(&path, WIDTH, HEIGHT, &[("normal.X", missed.clone()), ("depth.Z", depth.clone())])
        .unwrap();
    let layer = read_first_flat_layer_from_file(&path).unwrap().layer_data;
    let found: Vec<_> =
        layer.channel_data.list.iter().map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect())).collect();
    assert_eq!(found, [("depth.Z".to_owned(), depth), ("normal.X".to_owned(), missed)]);
}

#[test]
fn written_png_keeps_every_byte() {
    let samples = bytes8(3);
    let bytes = encode_png8("a.png", WIDTH, HEIGHT, samples.as_chunks().0).unwrap();
    assert_eq!(pixels("a.png", &bytes), colour(&samples, 3, |value| f32::from(value) / 255.0));
}

#[test]
fn writers_refuse_what_is_no_image() {
    let empty = Image { width: 0, height: 0, pixels: vec![] };
    let short = Image { width: 7, height: 5, pixels: vec![[0.0; 3]; 34] };
    let ones = || vec![1.0; 35];
    for error in [
        encode_exr("out.exr", &empty).unwrap_err(),
        encode_exr("out.exr", &short).unwrap_err(),
        encode_exr_channels("out.exr", 7, 5, &[]).unwrap_err(),
        encode_exr_channels("out.exr", 7, 5, &[("Z", ones()), ("Z", ones())]).unwrap_err(),
        encode_exr_channels("out.exr", 7, 5, &[("", ones())]).unwrap_err(),
        encode_exr_channels("out.exr", 7, 5, &[("Z", vec![1.0])]).unwrap_err(),
        encode_png8("out.exr", 7, 5, &[[0; 3]; 3]).unwrap_err(),
        encode_png8("out.exr", 0, 5, &[]).unwrap_err(),
        images::write_png8(std::path::Path::new("no/such/folder/out.exr"), 1, 1, &[[0; 3]]).unwrap_err(),
    ] {
        assert!(error.file.ends_with("out.exr") && !error.mend.is_empty(), "{error}");
    }
}

fn mask(name: &str, bytes: &[u8]) -> Mask {
    images::read_mask(&files(&[(name, bytes)]), name).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn masks_count_above_127() {
    let gray: Vec<u8> = (0..35).map(|i| [0, 127, 128, 255][i % 4]).collect();
    let bits: Vec<bool> = gray.iter().map(|&value| value > 127).collect();
    let expected = Mask { width: WIDTH, height: HEIGHT, bits };
    let repeat = |parts: &dyn Fn(u8) -> Vec<u8>| gray.iter().flat_map(|&value| parts(value)).collect::<Vec<u8>>();
    assert_eq!(mask("m.png", &png(&gray, ExtendedColorType::L8)), expected);
    assert_eq!(mask("m.png", &png(&repeat(&|v| vec![v, 9]), ExtendedColorType::La8)), expected);
    assert_eq!(mask("m.png", &png(&repeat(&|v| vec![v; 3]), ExtendedColorType::Rgb8)), expected);
    assert_eq!(mask("m.png", &png(&repeat(&|v| vec![v, v, v, 0]), ExtendedColorType::Rgba8)), expected);
    assert_eq!(mask("m.tif", &tiff(&gray, ExtendedColorType::L8)), expected);
    let words: Vec<u16> = gray.iter().map(|&value| u16::from(value) * 257).collect();
    assert_eq!(mask("m.png", &png(&native(&words), ExtendedColorType::L16)), expected);
    assert!(!mask("m.png", &png(&[0; 35], ExtendedColorType::L8)).bits.contains(&true));
}

#[test]
fn masks_of_one_bit() {
    let rows = [0b1010_1010u8, 0, 0xff, 0b0100_0000, 0b0000_0010];
    let encoded = png_of_one_bit(&rows);
    let found = mask("m.png", &encoded).bits;
    let expected: Vec<bool> = rows.iter().flat_map(|row| (0..7).map(move |bit| row >> (7 - bit) & 1 == 1)).collect();
    assert_eq!(found, expected);
}
