//! Agreement with Mitsuba 3: every reference capture, block by block.
//!
//! A reference photo is the mean of 8 renders of 1,024 samples, beside its standard error. A block of 8x8 pixels agrees
//! where the means differ by less than 4 combined standard errors plus 0.5 % of the photo's mean; 99 % of the blocks
//! must, and the photo's mean must within 0.3 %.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_scene::files::DirectoryFiles;
use gonio_scene::{Assets, Capture, image};
use gonio_tests::{captures, render};
use std::path::Path;

const BLOCK: usize = 8;
const SAMPLES: u32 = 512;

struct Agreement {
    blocks: usize,
    agreeing: usize,
    /// Relative difference of the photo's mean, largest over channels with light.
    mean: f64,
}

fn compare(folder: &Path) -> Vec<Agreement> {
    let files = DirectoryFiles::new(folder);
    let capture = Capture::read(&files).unwrap();
    let assets = Assets::load(&capture, &files).unwrap();
    let films = render(&capture, assets, SAMPLES, 1);
    capture
        .photos
        .iter()
        .zip(films)
        .map(|(photo, film)| {
            let reference = image::read(&files, &photo.file).unwrap();
            let error_file = photo.file.replace(".exr", ".stderr.exr");
            let error = image::read(&files, &error_file).unwrap();
            let (w, h) = (reference.width as usize, reference.height as usize);
            let total: f64 = reference.pixels.iter().flatten().map(|v| f64::from(*v)).sum();
            let photo_mean = total / (3 * w * h) as f64;
            let mut out = Agreement { blocks: 0, agreeing: 0, mean: 0.0 };
            for c in 0..3 {
                for by in 0..h / BLOCK {
                    for bx in 0..w / BLOCK {
                        let (mut difference, mut variance) = (0.0, 0.0);
                        for k in 0..BLOCK * BLOCK {
                            let i = (by * BLOCK + k / BLOCK) * w + bx * BLOCK + k % BLOCK;
                            let [a, b] = [f64::from(film.halves[0][i][c]), f64::from(film.halves[1][i][c])];
                            difference += (a + b) / 2.0 - f64::from(reference.pixels[i][c]);
                            variance += (a - b) * (a - b) / 4.0 + f64::from(error.pixels[i][c]).powi(2);
                        }
                        let n = (BLOCK * BLOCK) as f64;
                        out.blocks += 1;
                        let bound = 4.0 * variance.sqrt() / n + 0.005 * photo_mean;
                        out.agreeing += usize::from((difference / n).abs() < bound);
                    }
                }
                let sum = |f: &dyn Fn(usize) -> f64| (0..w * h).map(f).sum::<f64>();
                let ours = sum(&|i| f64::from(film.halves[0][i][c] + film.halves[1][i][c]) / 2.0);
                let theirs = sum(&|i| f64::from(reference.pixels[i][c]));
                if theirs > 0.0 {
                    out.mean = out.mean.max((ours / theirs - 1.0).abs());
                }
            }
            out
        })
        .collect()
}

#[test]
fn every_reference_capture_agrees() {
    let mut folders: Vec<_> =
        std::fs::read_dir(captures().join("reference")).unwrap().map(|e| e.unwrap().path()).collect();
    folders.sort();
    assert!(folders.len() >= 11, "the reference captures are missing");
    let mut failures = Vec::new();
    for folder in folders {
        for (i, a) in compare(&folder).iter().enumerate() {
            let share = a.agreeing as f64 / a.blocks as f64;
            let line = format!(
                "{} photo {i}: {:.2} % of {} blocks agree, mean off by {:.3} %",
                folder.file_name().unwrap().to_string_lossy(),
                share * 100.0,
                a.blocks,
                a.mean * 100.0
            );
            println!("{line}");
            if share < 0.99 || a.mean > 0.003 {
                failures.push(line);
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
