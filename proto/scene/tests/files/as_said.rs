//! Images whose header says what their values mean: they are read so, or refused.

use ::image::ExtendedColorType;
use exr::meta::attribute::Chromaticities;
use exr::prelude::*;
use gonio_scene::image::{self as images, Image as Picture};
use tiff::encoder::{TiffEncoder, TiffKind, colortype};
use tiff::tags::Tag;

use crate::files;
use crate::fixture_images::{HEIGHT, WIDTH, crc32, hdr, layer, png, values};

fn read(name: &str, bytes: &[u8]) -> Picture {
    images::read(&files(&[(name, bytes)]), name).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(name: &str, bytes: &[u8], says: &str) {
    let capture = files(&[(name, bytes)]);
    let error = images::read(&capture, name).expect_err(says).to_string();
    assert!(error.starts_with(name) && error.contains(says), "{error}");
}

fn near(found: &Picture, expected: impl Fn([f32; 3]) -> [f32; 3], tolerance: f32) {
    for (found, value) in found.pixels.iter().zip(values()) {
        let expected = expected(value);
        let scale = expected.iter().chain(&value).fold(1e-3, |a: f32, b| a.max(b.abs()));
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() <= tolerance * scale, "{found:?} {expected:?}");
        }
    }
}

/// A Radiance HDR of [`values`] with further lines in its header.
fn hdr_with(lines: &str) -> Vec<u8> {
    let bytes = hdr(&values());
    let at = bytes.iter().position(|&byte| byte == b'\n').unwrap() + 1;
    [&bytes[..at], lines.as_bytes(), &bytes[at..]].concat()
}

#[test]
fn an_hdr_is_divided_by_its_exposures_and_corrections() {
    near(&read("a.hdr", &hdr_with("EXPOSURE=2\nEXPOSURE= 4.0\n")), |v| v.map(|x| x / 8.0), 0.02);
    let both = read("a.hdr", &hdr_with("COLORCORR=2 1 0.5\nEXPOSURE=2\n"));
    near(&both, |[r, g, b]| [r / 4.0, g / 2.0, b], 0.02);
    for (line, says) in [
        ("EXPOSURE=0\n", "EXPOSURE: is 0"),
        ("EXPOSURE=bright\n", "EXPOSURE: is bright, not 1 numbers"),
        ("COLORCORR=1 1\n", "COLORCORR: is 1 1, not 3"),
        ("COLORCORR=1 -1 1\n", "COLORCORR: is 1 -1 1, which no value"),
        ("PRIMARIES=0.64 0.33\n", "PRIMARIES: is 0.64 0.33, not 8"),
        ("PRIMARIES=0.3 0.3 0.3 0.3 0.3 0.3 0.3 0.3\n", "PRIMARIES: are primaries that span no colours"),
    ] {
        refused("a.hdr", &hdr_with(line), says);
    }
}

/// Rec. 2020 to Rec. 709: ITU-R BT.2407, annex 1.
fn from_2020([r, g, b]: [f32; 3]) -> [f32; 3] {
    [1.6605 * r - 0.5876 * g - 0.0728 * b, -0.1246 * r + 1.1329 * g - 0.0083 * b, -0.0182 * r - 0.1006 * g + 1.1187 * b]
}

#[test]
fn other_primaries_become_rec_709() {
    let rec709 = hdr_with("PRIMARIES=0.64 0.33 0.30 0.60 0.15 0.06 0.3127 0.3290\n");
    assert_eq!(read("a.hdr", &rec709), read("a.hdr", &hdr(&values())));
    let rec2020 = hdr_with("PRIMARIES=0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290\n");
    near(&read("a.hdr", &rec2020), from_2020, 0.02);

    let mut bytes = hdr(&values());
    let at = bytes.windows(15).position(|word| word == b"32-bit_rle_rgbe").unwrap();
    bytes[at..at + 15].copy_from_slice(b"32-bit_rle_xyze");
    // IEC 61966-2-1, annex F: XYZ to linear sRGB.
    let linear = |[x, y, z]: [f32; 3]| {
        [
            3.2406 * x - 1.5372 * y - 0.4986 * z,
            -0.9689 * x + 1.8758 * y + 0.0415 * z,
            0.0557 * x - 0.2040 * y + 1.0570 * z,
        ]
    };
    near(&read("a.hdr", &bytes), linear, 0.03);
    assert_eq!(images::dimensions(&files(&[("a.hdr", &bytes)]), "a.hdr").unwrap(), (WIDTH, HEIGHT));
}

fn exr_with(change: impl FnOnce(&mut ImageAttributes, &mut LayerAttributes), alpha: Option<FlatSamples>) -> Vec<u8> {
    let channel = |index: usize| FlatSamples::F32(values().iter().map(|pixel| pixel[index]).collect());
    let mut channels = vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
    channels.extend(alpha.map(|alpha| ("A", alpha)));
    let mut layers = vec![layer("main", (0, 0), (WIDTH as usize, HEIGHT as usize), channels, Compression::ZIP16)];
    let mut attributes = ImageAttributes::new(IntegerBounds::new((0, 0), (WIDTH as usize, HEIGHT as usize)));
    change(&mut attributes, &mut layers[0].attributes);
    let mut bytes = Vec::new();
    let image = Image::from_layers(attributes, layers);
    image.write().to_buffered(std::io::Cursor::new(&mut bytes)).unwrap();
    bytes
}

fn places(red: [f32; 2], green: [f32; 2], blue: [f32; 2]) -> Chromaticities {
    let place = |[x, y]: [f32; 2]| Vec2(x, y);
    let white = Vec2(0.3127, 0.329);
    Chromaticities { red: place(red), green: place(green), blue: place(blue), white }
}

#[test]
fn an_exr_of_other_chromaticities_becomes_rec_709() {
    let rec2020 = places([0.708, 0.292], [0.17, 0.797], [0.131, 0.046]);
    near(&read("a.exr", &exr_with(|image, _| image.chromaticities = Some(rec2020), None)), from_2020, 1e-4);
    let rec709 = places([0.64, 0.33], [0.3, 0.6], [0.15, 0.06]);
    assert_eq!(read("a.exr", &exr_with(|image, _| image.chromaticities = Some(rec709), None)).pixels, values());
    let none = places([0.3, 0.3], [0.3, 0.3], [0.3, 0.3]);
    refused("a.exr", &exr_with(|image, _| image.chromaticities = Some(none), None), "chromaticities: span no colours");
    let nits = exr_with(|_, layer| layer.white_luminance = Some(100.0), None);
    assert_eq!(images::claims(&files(&[("a.exr", &nits)]), "a.exr").unwrap().white_luminance, Some(100.0));
}

fn alpha(name: &str, bytes: &[u8]) -> Option<Vec<bool>> {
    images::read_with_alpha(&files(&[(name, bytes)]), name).unwrap_or_else(|error| panic!("{error}")).1
}

#[test]
fn alpha_says_which_pixels_count() {
    let opaque: Vec<bool> = (0..35).map(|i| i % 3 == 1).collect();
    let rgba: Vec<u8> = opaque.iter().flat_map(|&o| [10, 20, 30, if o { 255 } else { 0 }]).collect();
    assert_eq!(alpha("a.png", &png(&rgba, ExtendedColorType::Rgba8)), Some(opaque.clone()));
    assert_eq!(alpha("a.png", &png(&[9; 140], ExtendedColorType::Rgba8)), None);
    let floats = FlatSamples::F32(opaque.iter().map(|&o| f32::from(u8::from(o))).collect());
    assert_eq!(alpha("a.exr", &exr_with(|_, _| (), Some(floats))), Some(opaque.clone()));

    // A mask in alpha, as cut-out tools write it: gray is the same everywhere.
    let mask = |samples: &[u8], color| {
        images::read_mask(&files(&[("m.png", &png(samples, color))]), "m.png").map(|mask| mask.bits)
    };
    let with = |gray: &dyn Fn(bool) -> u8| -> Vec<u8> {
        opaque.iter().flat_map(|&o| [gray(o), if o { 255 } else { 0 }]).collect()
    };
    assert_eq!(mask(&with(&|_| 0), ExtendedColorType::La8).unwrap(), opaque);
    assert_eq!(mask(&with(&|_| 255), ExtendedColorType::La8).unwrap(), opaque);
    assert_eq!(mask(&with(&|o| if o { 200 } else { 3 }), ExtendedColorType::La8).unwrap(), opaque);
    let error = mask(&with(&|o| if o { 3 } else { 200 }), ExtendedColorType::La8).unwrap_err().to_string();
    assert!(error.contains("pixel (column 0, row 0): has a gray value and an alpha that disagree"), "{error}");
    assert_eq!(
        mask(&rgba.iter().map(|v| if *v < 40 { 255 } else { *v }).collect::<Vec<_>>(), ExtendedColorType::Rgba8)
            .unwrap()
            .len(),
        35
    );
}

fn tiff_of<C: colortype::ColorType>(samples: &[C::Inner], orientation: Option<u16>) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut bytes = std::io::Cursor::new(Vec::new());
    write::<C, tiff::encoder::TiffKindStandard>(TiffEncoder::new(&mut bytes).unwrap(), samples, orientation);
    bytes.into_inner()
}

fn write<C: colortype::ColorType, K: TiffKind>(
    mut encoder: TiffEncoder<&mut std::io::Cursor<Vec<u8>>, K>,
    samples: &[C::Inner],
    orientation: Option<u16>,
) where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut image = encoder.new_image::<C>(WIDTH, HEIGHT).unwrap();
    if let Some(orientation) = orientation {
        image.encoder().write_tag(Tag::Orientation, orientation).unwrap();
    }
    image.write_data(samples).unwrap();
}

#[test]
fn tiff_samples_are_what_their_format_says() {
    let colour: Vec<f32> = (0..105).map(|i| i as f32 / 104.0).collect();
    let expected: Vec<[f32; 3]> = colour.as_chunks().0.to_vec();
    let close = |bytes: &[u8]| {
        for (found, expected) in read("a.tif", bytes).pixels.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
    };
    let whole: Vec<u32> = colour.iter().map(|v| (f64::from(*v) * f64::from(u32::MAX)) as u32).collect();
    close(&tiff_of::<colortype::RGB32>(&whole, None));
    close(&tiff_of::<colortype::RGB64Float>(&colour.iter().map(|v| f64::from(*v)).collect::<Vec<_>>(), None));
    let gray: Vec<f32> = colour[..35].to_vec();
    let found = read("a.tif", &tiff_of::<colortype::Gray32Float>(&gray, None));
    assert!(found.pixels.iter().zip(&gray).all(|(pixel, value)| *pixel == [*value; 3]));
    let mut big = std::io::Cursor::new(Vec::new());
    write::<colortype::RGB32Float, _>(TiffEncoder::new_big(&mut big).unwrap(), &colour, None);
    close(&big.into_inner());

    let signed: Vec<i16> = (0..35).collect();
    refused("a.tif", &tiff_of::<colortype::GrayI16>(&signed, None), "samples with a sign");
    refused("a.tif", &tiff_of::<colortype::CMYK8>(&[7; 140], None), "pixels of the kind CMYK");
    refused("a.tif", &tiff_of::<colortype::Gray8>(&[7; 35], Some(6)), "Orientation: says by its orientation 6");
    read("a.tif", &tiff_of::<colortype::Gray8>(&[7; 35], Some(1)));
}

/// A JPEG with an EXIF block that states an orientation.
fn turned_jpeg(orientation: u16) -> Vec<u8> {
    let bytes = crate::fixture_images::jpeg(&[128; 35], ExtendedColorType::L8);
    let mut exif = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    exif.extend(u32::from(orientation).to_le_bytes());
    exif.extend([0; 4]);
    let length = (exif.len() as u16 + 2).to_be_bytes();
    [&bytes[..2], &[0xff, 0xe1], &length, &exif, &bytes[2..]].concat()
}

#[test]
fn a_photo_that_is_to_be_shown_turned_is_refused_by_its_header() {
    for orientation in 2..=8 {
        refused("a.jpg", &turned_jpeg(orientation), &format!("orientation {orientation}"));
    }
    let capture = |bytes: &[u8]| files(&[("a.jpg", bytes)]);
    assert!(images::dimensions(&capture(&turned_jpeg(6)), "a.jpg").is_err());
    assert!(images::dimensions(&capture(&turned_jpeg(1)), "a.jpg").is_ok());
}

#[test]
fn a_png_claims_a_curve_and_primaries() {
    let plain = png(&[7; 35], ExtendedColorType::L8);
    let claims = |bytes: &[u8]| images::claims(&files(&[("a.png", bytes)]), "a.png").unwrap();
    assert_eq!(claims(&plain), images::Claims::default());
    let with = |name: &[u8; 4], data: &[u32]| {
        let content = [&name[..], &data.iter().flat_map(|value| value.to_be_bytes()).collect::<Vec<u8>>()].concat();
        let chunk = [&(content.len() as u32 - 4).to_be_bytes()[..], &content, &crc32(&content).to_be_bytes()].concat();
        // Behind the signature and the header chunk.
        [&plain[..33], &chunk, &plain[33..]].concat()
    };
    assert_eq!(claims(&with(b"gAMA", &[45455])).gamma, Some(0.45455));
    let rec709 = [31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000];
    assert!(!claims(&with(b"cHRM", &rec709)).other_primaries);
    let rec2020 = [31270, 32900, 70800, 29200, 17000, 79700, 13100, 4600];
    assert!(claims(&with(b"cHRM", &rec2020)).other_primaries);
    // A length that reaches beyond the file ends the search.
    let mut broken = with(b"gAMA", &[1]);
    broken[33..37].copy_from_slice(&u32::MAX.to_be_bytes());
    assert!(!claims(&broken).other_primaries);
}
