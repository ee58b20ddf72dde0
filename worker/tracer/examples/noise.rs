//! What noise costs, by the library alone on one thread: `noise CAPTURE... [--samples N] [--seeds K] [--photos P]`.
//!
//! For each capture one line of JSON: CPU seconds of a render of `samples` samples (both halves together), the mean variance of
//! a pixel's radiance (over channels, then pixels, without the noisiest 1 %), of the mean of 8x8 pixels times 64, and the products
//! of both with the seconds; the mean radiance, which must not depend on how it is sampled.
//! With `--columns`, the parameters that the capture frees are differentiated, and what is said of a pixel is said of its first
//! derivative plane as well.

use anyhow::{Context, Result, bail};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::film::{PixelSet, Tile};
use gonio_scene::{Assets, Capture};
use gonio_tracer::{Prepared, Stage, TileTask};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Side of the blocks of pixels whose means are looked at.
const BLOCK: usize = 8;
/// The share of the pixels that fireflies are not looked for in.
const KEPT: f64 = 0.99;

/// What is asked for.
struct Options {
    captures: Vec<String>,
    samples: u32,
    seeds: u64,
    photos: usize,
    columns: bool,
}

/// Radiance and the first derivative plane, each by pixel.
type Image = [Vec<[f64; 3]>; 2];

fn main() -> Result<()> {
    let options = options()?;
    for capture in &options.captures {
        println!("{}", measure(capture, &options)?);
    }
    Ok(())
}

fn options() -> Result<Options> {
    let mut options = Options { captures: Vec::new(), samples: 64, seeds: 4, photos: 2, columns: false };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut number = || -> Result<u32> {
            let text = words.next().with_context(|| format!("{word} needs a number"))?;
            text.parse().with_context(|| format!("{word} {text}: no whole number"))
        };
        match word.as_str() {
            "--samples" => options.samples = number()?.max(2),
            "--seeds" => options.seeds = u64::from(number()?.max(2)),
            "--photos" => options.photos = number()? as usize,
            "--columns" => options.columns = true,
            flag if flag.starts_with("--") => bail!("unknown option {flag}"),
            _ => options.captures.push(word),
        }
    }
    if options.captures.is_empty() {
        bail!("usage: noise CAPTURE... [--samples N] [--seeds K] [--photos P] [--columns]");
    }
    Ok(options)
}

fn measure(folder: &str, options: &Options) -> Result<String> {
    let files = DirectoryFiles { root: Path::new(folder).to_path_buf(), max_bytes: 1 << 30 };
    let capture = Capture::read(&files)?;
    let columns = if options.columns { capture.free_parameters()? } else { Vec::new() };
    let photos = capture.photos.len().min(options.photos);
    let stage = Stage::new(capture.clone(), Assets::load(&capture, &files)?);
    let prepared = stage.prepare(&[], &columns)?;
    let (mut least, mut variances, mut blocks, mut mean) = (f64::INFINITY, [vec![], vec![]], [0.0; 2], 0.0);
    let mut all = Vec::new();
    for seed in 0..options.seeds {
        let begin = cpu_seconds()?;
        let images = (0..photos).map(|photo| render(&prepared, photo, seed, options)).collect::<Result<Vec<_>>>()?;
        least = least.min(cpu_seconds()? - begin);
        all.push(images);
    }
    for photo in 0..photos {
        let (width, height) = prepared.size(photo).context("a photo without a size")?;
        for plane in 0..2 {
            let images: Vec<&[[f64; 3]]> = all.iter().map(|images| &images[photo][plane][..]).collect();
            if images[0].is_empty() {
                continue;
            }
            variances[plane].extend((0..images[0].len()).map(|p| variance(&images, |image| image[p])));
            let (columns, rows) = (width as usize / BLOCK, height as usize / BLOCK);
            let block = |k: usize| {
                let (x, y) = (k % columns * BLOCK, k / columns * BLOCK);
                variance(&images, |image| {
                    let mut sum = [0.0; 3];
                    for p in (0..BLOCK * BLOCK).map(|i| (y + i / BLOCK) * width as usize + x + i % BLOCK) {
                        (0..3).for_each(|c| sum[c] += image[p][c]);
                    }
                    sum.map(|s| s / BLOCK as f64)
                })
            };
            blocks[plane] += (0..columns * rows).map(block).sum::<f64>() / (columns * rows * photos) as f64;
            if plane == 0 {
                let sum: f64 = images.iter().flat_map(|image| image.iter().flatten()).sum();
                mean += sum / (images.len() * images[0].len() * 3 * photos) as f64;
            }
        }
    }
    let mut line = format!("{{\"capture\": {:?}, \"mean\": {mean:.6}, \"cpu\": {least:.4}", capture.name);
    for (plane, name) in ["radiance", "derivative"].iter().enumerate() {
        let sorted = &mut variances[plane];
        if sorted.is_empty() {
            continue;
        }
        sorted.sort_by(f64::total_cmp);
        let kept = &sorted[..(sorted.len() as f64 * KEPT) as usize];
        let trimmed = kept.iter().sum::<f64>() / kept.len() as f64;
        let whole = sorted.iter().sum::<f64>() / sorted.len() as f64;
        line += &format!(
            ", \"{name}\": {{\"variance\": {trimmed:.4e}, \"product\": {:.4e}, \"block\": {:.4e}, \"block_over_pixel\": {:.3}}}",
            trimmed * least,
            blocks[plane] * least,
            blocks[plane] / whole
        );
    }
    Ok(line + "}")
}

/// The variance across images of what `value` picks from each, mean over channels.
fn variance(images: &[&[[f64; 3]]], value: impl Fn(&[[f64; 3]]) -> [f64; 3]) -> f64 {
    let values: Vec<[f64; 3]> = images.iter().map(|image| value(image)).collect();
    let count = values.len() as f64;
    let channel = |c: usize| {
        let mean = values.iter().map(|v| v[c]).sum::<f64>() / count;
        values.iter().map(|v| (v[c] - mean) * (v[c] - mean)).sum::<f64>() / (count - 1.0)
    };
    (0..3).map(channel).sum::<f64>() / 3.0
}

fn render(prepared: &Prepared, photo: usize, seed: u64, options: &Options) -> Result<Image> {
    let (width, height) = prepared.size(photo).context("a photo without a size")?;
    let mut image: Image = [vec![[0.0; 3]; width as usize * height as usize], Vec::new()];
    if prepared.planes() > 0 {
        image[1] = image[0].clone();
    }
    for tile in Tile::cover(width, height) {
        let pixels = PixelSet::from_flags(std::iter::repeat_n(true, tile.len()));
        let samples = 0..options.samples / 2;
        let task = TileTask { photo, tile, pixels: &pixels, samples, difference_samples: 0, forward_samples: 0, seed };
        let film = prepared.render(&task, &AtomicBool::new(false)).context("no film")?;
        for p in 0..tile.len() as u32 {
            let at = (tile.y + p / tile.width) * width + tile.x + p % tile.width;
            for (plane, image) in image.iter_mut().enumerate().filter(|(_, image)| !image.is_empty()) {
                image[at as usize] = std::array::from_fn(|c| {
                    let value = |half| f64::from(film.pixel(half, p as usize)[3 * plane + c]);
                    (value(0) + value(1)) / 2.0
                });
            }
        }
    }
    Ok(image)
}

/// CPU time of this thread: other programs on the machine do not count.
fn cpu_seconds() -> Result<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").context("needs Linux")?;
    let first = text.split_whitespace().next().context("an empty schedstat")?;
    Ok(first.parse::<f64>()? * 1e-9)
}
