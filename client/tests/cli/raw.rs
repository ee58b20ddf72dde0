//! `gonio develop` and `gonio chart`, on DNG files made here by the specification, and on a real one against rawpy.

use crate::fixture::{gonio, json, refused, succeeds};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::{Image, read};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// From XYZ to Rec. 709, in ten-thousandths: a camera with this matrix sees Rec. 709.
const MATRIX: [i32; 9] = [32410, -15374, -4986, -9692, 18760, 416, 556, -2040, 10570];
const BLACK: u16 = 100;
const WHITE: u16 = 4100;

/// A DNG of an uncompressed Bayer mosaic, red first, 2 x 2 cells of `cells` across, by the DNG specification 1.4.
fn dng(cells: [usize; 2], neutral: [u32; 3], value: impl Fn(usize, usize, usize) -> u16) -> Vec<u8> {
    let [width, height] = cells.map(|side| 2 * side);
    let shorts = |values: &[u16]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
    let longs = |values: &[u32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
    let matrix: Vec<u8> = MATRIX.iter().flat_map(|n| [n.to_le_bytes(), 10000_i32.to_le_bytes()].concat()).collect();
    let gray: Vec<u32> = neutral.iter().flat_map(|n| [*n, 1000]).collect();
    let noise: Vec<u8> = [2e-4_f64, 1e-6].iter().flat_map(|value| value.to_le_bytes()).collect();
    let colour = |x: usize, y: usize| [[0, 1], [1, 2]][y % 2][x % 2];
    let strip: Vec<u16> =
        (0..width * height).map(|k| value(k % width / 2, k / width / 2, colour(k % width, k / width))).collect();
    // Tag, type (1 byte, 2 text, 3 short, 4 long, 5 rational, 10 signed rational, 12 double), data.
    let mut entries: Vec<(u16, u16, Vec<u8>)> = vec![
        (254, 4, longs(&[0])),
        (256, 4, longs(&[width as u32])),
        (257, 4, longs(&[height as u32])),
        (258, 3, shorts(&[16])),
        (259, 3, shorts(&[1])),
        (262, 3, shorts(&[32803])),
        (271, 2, b"Gonio\0".to_vec()),
        (272, 2, b"Test\0".to_vec()),
        (273, 4, longs(&[0])),
        (277, 3, shorts(&[1])),
        (278, 4, longs(&[height as u32])),
        (279, 4, longs(&[2 * strip.len() as u32])),
        (33421, 3, shorts(&[2, 2])),
        (33422, 1, vec![0, 1, 1, 2]),
        (50706, 1, vec![1, 4, 0, 0]),
        (50708, 2, b"Gonio Test\0".to_vec()),
        (50714, 3, shorts(&[BLACK])),
        (50717, 3, shorts(&[WHITE])),
        (50721, 10, matrix),
        (50728, 5, longs(&gray)),
        (50778, 3, shorts(&[21])),
        (51041, 12, noise),
    ];
    let size = [0, 1, 1, 2, 4, 8, 0, 0, 0, 0, 8, 0, 8];
    let start = 8 + 2 + 12 * entries.len() + 4;
    let long: usize =
        entries.iter().map(|(.., data)| if data.len() > 4 { data.len().next_multiple_of(2) } else { 0 }).sum();
    entries[8].2 = longs(&[(start + long) as u32]);
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend((entries.len() as u16).to_le_bytes());
    let mut tail = Vec::new();
    for (tag, kind, data) in &entries {
        let count = data.len() / size[usize::from(*kind)];
        bytes.extend([&tag.to_le_bytes()[..], &kind.to_le_bytes(), &(count as u32).to_le_bytes()].concat());
        if data.len() > 4 {
            bytes.extend(((start + tail.len()) as u32).to_le_bytes());
            tail.extend(data);
            tail.resize(tail.len().next_multiple_of(2), 0);
        } else {
            bytes.extend(data);
            bytes.resize(bytes.len() + 4 - data.len(), 0);
        }
    }
    bytes.extend([0; 4]);
    bytes.extend(tail);
    bytes.extend(shorts(&strip));
    bytes
}

fn image(top: &Path, name: &str) -> Image {
    read(&DirectoryFiles::new(top), name).unwrap()
}

fn near(found: [f32; 3], expected: [f64; 3], tolerance: f64) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((f64::from(*found) - expected).abs() <= tolerance, "{found:?} {expected:?}");
    }
}

/// Light that rises to the right and down, another in every channel: what bilinear interpolation keeps.
fn ramp(x: usize, y: usize, colour: usize) -> u16 {
    BLACK + [40, 60, 20][colour] * x as u16 + 100 * y as u16 + 400
}

#[test]
fn a_raw_file_becomes_linear_light_by_its_levels_and_matrices() {
    let top = tempfile::tempdir().unwrap();
    let at = top.path();
    std::fs::write(at.join("a.dng"), dng([12, 8], [1000, 1000, 1000], ramp)).unwrap();
    let light = |x: usize, y: usize| [0, 1, 2].map(|c| f64::from(ramp(x, y, c) - BLACK) / f64::from(WHITE - BLACK));
    let told = json(&succeeds(
        at,
        &["develop", "a.dng", "--out", "a.exr", "--demosaic", "superpixel", "--colour", "camera", "--json"],
    ));
    assert_eq!(
        (&told["width"], &told["raw"]["black"], &told["raw"]["white"]),
        (&12.into(), &100.0.into(), &4100.0.into())
    );
    let found = image(at, "a.exr");
    for k in 0..96 {
        near(found.pixels[k], light(k % 12, k / 12), 1e-6);
    }
    // The camera sees Rec. 709, and its gray is D65 but for the digits of the matrix.
    succeeds(at, &["develop", "a.dng", "--out", "b.exr", "--demosaic", "superpixel"]);
    near(image(at, "b.exr").pixels[40], light(4, 3), 2e-4);
    // In the middle, a bilinear pixel lies within its neighbours' cells.
    succeeds(at, &["develop", "a.dng", "--out", "c.exr"]);
    let full = image(at, "c.exr");
    assert_eq!((full.width, full.height), (24, 16));
    near(full.pixels[8 * 24 + 12], light(6, 4), 0.03);
    // NoiseProfile: variance 2e-4 a value, 1e-6 at 0.
    assert!((told["raw"]["shot_noise"].as_f64().unwrap() / 2e-4 - 1.0).abs() < 1e-3, "{told}");
    assert!((told["raw"]["read_noise"].as_f64().unwrap() / 1e-3 - 1.0).abs() < 1e-3, "{told}");
    let said = String::from_utf8(gonio(at, &["develop", "a.dng", "--out", "d.exr"]).stdout).unwrap();
    assert!(said.contains("black 100.0, white 4100") && said.contains("keeps its colour"), "{said}");
}

#[test]
fn a_white_balance_makes_gray_and_clipped_values_are_masked() {
    let top = tempfile::tempdir().unwrap();
    let at = top.path();
    let gray = |x: usize, _: usize, colour: usize| {
        if x == 11 { WHITE } else { BLACK + (f64::from(300 * x as u16) * [0.5, 1.0, 0.8][colour]) as u16 }
    };
    std::fs::write(at.join("a.dng"), dng([12, 8], [500, 1000, 800], gray)).unwrap();
    let develop = |out: &'static str, balance: &'static str| {
        succeeds(at, &["develop", "a.dng", "--out", out, "--demosaic", "superpixel", "--white-balance", balance]);
        image(at, out).pixels[14]
    };
    near(develop("a.exr", "as-shot"), [0.15; 3], 2e-4);
    near(develop("b.exr", "0.5,1,0.8"), [0.15; 3], 2e-4);
    let kept = develop("c.exr", "none");
    assert!(kept[0] < 0.7 * kept[1], "the light keeps its colour: {kept:?}");
    let mask = image(at, "a.mask.png");
    assert_eq!(mask.pixels[..12].iter().map(|pixel| pixel[0]).collect::<Vec<_>>(), [vec![1.0; 11], vec![0.0]].concat());
}

#[test]
fn what_cannot_be_read_says_how_to_develop_it() {
    let top: TempDir = tempfile::tempdir().unwrap();
    let at = top.path();
    std::fs::write(at.join("a.nef"), b"MM\0*\0\0\0\x08 and no more").unwrap();
    refused(
        at,
        &["develop", "a.nef", "--out", "a.exr"],
        &["a.nef: is a RAW file that cannot be read here", "linear 16-bit TIFF"],
    );
    refused(at, &["noise", "a.nef"], &["a.nef: ", "darktable"]);
    let whole = dng([12, 8], [1000; 3], ramp);
    std::fs::write(at.join("b.dng"), &whole[..whole.len() - 40]).unwrap();
    refused(at, &["develop", "b.dng", "--out", "a.exr"], &["b.dng: ", "linear 16-bit TIFF"]);
    refused(at, &["develop", "b.dng", "--out", "a.exr", "--white-balance", "warm"], &["--white-balance", "as-shot"]);
    assert!(!at.join("a.exr").exists());
    std::fs::write(at.join("m.json"), "{}").unwrap();
    std::fs::write(at.join("c.dng"), whole).unwrap();
    refused(at, &["develop", "c.dng", "--out", "a.exr", "--matrix", "m.json"], &["m.json: matrix: ", "gonio chart"]);
    refused(at, &["chart", "c.dng", "--corners", "1,1,4,1,4,4,1,4"], &["c.dng: --corners: "]);
}

/// The real file; `None` where the folder of shared data is not there.
fn real() -> Option<PathBuf> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/real/raw/colorchart.dng");
    if !file.is_file() {
        eprintln!("skipped: {} is not there", file.display());
        return None;
    }
    Some(file)
}

/// Of rawpy 0.28 (LibRaw): postprocess(half_size=True, gamma=(1, 1), no_auto_bright=True, output_bps=16, output_color=raw,
/// user_wb=[1, 1, 1, 1]), over 65535.
const RAWPY: [([usize; 2], [f64; 3]); 5] = [
    ([358, 312], [0.009628, 0.012253, 0.007935]),
    ([626, 307], [0.026795, 0.056779, 0.027390]),
    ([629, 461], [0.003769, 0.005142, 0.004257]),
    ([352, 466], [0.079026, 0.118929, 0.052918]),
    ([500, 390], [0.031571, 0.045762, 0.011505]),
];

#[test]
fn a_real_dng_is_what_rawpy_makes_of_it_and_its_chart_comes_near_its_colours() {
    let Some(file) = real() else { return };
    let top = tempfile::tempdir().unwrap();
    let at = top.path();
    let file = file.display().to_string();
    succeeds(at, &["develop", &file, "--out", "a.exr", "--demosaic", "superpixel", "--colour", "camera"]);
    let found = image(at, "a.exr");
    // LibRaw takes the largest value of the picture for white, so that all of its values are larger by one factor.
    let at_pixel = |[x, y]: [usize; 2]| found.pixels[y * found.width as usize + x];
    let (first, green) = (RAWPY[0].0, RAWPY[0].1[1]);
    let factor = f64::from(at_pixel(first)[1]) / green;
    assert!((factor - 0.7782).abs() < 1e-3, "{factor}");
    for (place, expected) in RAWPY {
        near(at_pixel(place), expected.map(|value| value * factor), 2e-4);
    }
    let corners = "716,624,1252,613,1259,923,703,932";
    let chart = ["chart", &file, "--corners", corners, "--edition", "before-2014", "--out", "m.json", "--json"];
    let told = json(&succeeds(at, &chart));
    let (before, after) = (told["mean_before"].as_f64().unwrap(), told["mean_after"].as_f64().unwrap());
    println!("dE2000 {before:.2} before, {after:.2} after");
    assert!(after < 4.0 && before > 3.0 * after, "{told}");
    refused(
        at,
        &["chart", &file, "--corners", "703,932,1259,923,1252,613,716,624"],
        &["--corners: shows the chart's patches", "716,624,1252,613,1259,923,703,932"],
    );
    succeeds(at, &["develop", &file, "--out", "c.exr", "--matrix", "m.json"]);
}
