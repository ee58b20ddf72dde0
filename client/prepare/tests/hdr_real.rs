//! The published stack of a church against its published map: Debevec and Malik's `memorial`, from the folder that
//! `GONIO_REAL` names, or from `../shared/real` beside the checkout; skipped where there is none.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_prepare::hdr::{Mark, Region, Shot, Stack, calibrate, correct_times, merge};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::{self, Image};
use std::path::PathBuf;

fn real(name: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    let folder = std::env::var_os("GONIO_REAL").map_or_else(beside, PathBuf::from).join(name);
    if !folder.is_dir() {
        println!("skipped: no {name} in GONIO_REAL or ../shared/real");
        return None;
    }
    Some(folder)
}

/// Differences in stops of two maps where `use_it`, after the median of each channel (`by_channel`) or of all is taken off.
fn stops(a: &Image, b: &Image, by_channel: bool, use_it: impl Fn(usize) -> bool) -> Vec<f64> {
    let mut all: [Vec<f64>; 3] = Default::default();
    for k in (0..a.pixels.len()).filter(|&k| use_it(k)) {
        for (c, channel) in all.iter_mut().enumerate() {
            if b.pixels[k][c] > 0.0 && a.pixels[k][c] > 0.0 {
                channel.push(f64::from(a.pixels[k][c] / b.pixels[k][c]).log2());
            }
        }
    }
    let median = |values: &[f64]| {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    println!("channel offsets in stops: {:?}", all.each_ref().map(|channel| median(channel)));
    let whole = median(&all.concat());
    all.iter()
        .flat_map(|channel| {
            let offset = if by_channel { median(channel) } else { whole };
            channel.iter().map(move |value| (value - offset).abs())
        })
        .collect()
}

#[test]
fn the_published_map_is_found_again() {
    let Some(folder) = real("memorial") else { return };
    let files = DirectoryFiles::new(&folder);
    let shots = (0..16)
        .map(|k| {
            let name = format!("memorial{:04}.png", 61 + k);
            let image = image::read(&files, &name).unwrap();
            Shot { name, image, seconds: 32.0 / f64::from(1 << k) }
        })
        .collect();
    let shots: Vec<Shot> = shots;
    // The shortest exposures hold a window and little else: there nobody could tell.
    for wrong in [2, 5] {
        let mut shots = shots.clone();
        shots[wrong].seconds *= 1.7;
        let mut stack = Stack::new(shots, Some([0, 0, 255])).unwrap();
        let suspects = correct_times(&mut stack, Region::All, None);
        println!("{suspects:?}");
        assert_eq!(suspects.len(), 1);
        assert_eq!(suspects[0].name, format!("memorial{:04}.png", 61 + wrong));
        assert!((suspects[0].found / suspects[0].given * 1.7 - 1.0).abs() < 0.15, "{suspects:?}");
    }
    let start = std::time::Instant::now();
    let mut stack = Stack::new(shots, Some([0, 0, 255])).unwrap();
    let suspects = correct_times(&mut stack, Region::All, None);
    println!("suspects {suspects:?}, {:?}", start.elapsed());
    assert!(suspects.is_empty(), "the published times are right: {suspects:?}");
    let response = calibrate(&stack, Region::All).unwrap();
    assert!(response.log_exposure.iter().all(|table| table.windows(2).all(|pair| pair[1] > pair[0])));
    let merged = merge(&stack, &response);
    println!("merged, {:?}", start.elapsed());
    let count = |mark| merged.marks.iter().filter(|&&found| found == mark).count();
    println!(
        "good {} moved {} dark {} saturated {} outside {}",
        count(Mark::Good),
        count(Mark::Moved),
        count(Mark::Dark),
        count(Mark::Saturated),
        count(Mark::Outside)
    );
    // Nothing moves in a church at night: what is left is the scans' misregistration.
    let moved = count(Mark::Moved) as f64 / merged.marks.len() as f64;
    println!("{:.4} % with a shot left out", 100.0 * moved);
    assert!(moved < 0.001, "{moved}");
    let published = image::read(&files, "memorial.hdr").unwrap();
    let held = |k: usize| {
        let blue = (0..16).any(|shot| stack.value(shot, k).is_none());
        !blue && merged.marks[k] < Mark::Dark
    };
    for by_channel in [false, true] {
        let mut found = stops(&merged.radiance, &published, by_channel, held);
        found.sort_by(f64::total_cmp);
        let at = |part: f64| found[(part * found.len() as f64) as usize];
        println!("by channel {by_channel}: median {:.4} 90 % {:.4} of {} values", at(0.5), at(0.9), found.len());
        assert!(at(0.5) < 0.15);
    }
    if let Some(out) = std::env::var_os("GONIO_TEST_OUT") {
        image::write_exr(&PathBuf::from(&out).join("memorial.exr"), &merged.radiance).unwrap();
        std::fs::write(PathBuf::from(&out).join("memorial.svg"), gonio_prepare::hdr::plot(&response)).unwrap();
        let shown = gonio_prepare::hdr::preview(&merged.radiance);
        image::write_png8(&PathBuf::from(out).join("memorial.png"), published.width, published.height, &shown).unwrap();
    }
}
