//! Noise between photos of one scene.

use super::level::{Level, half_lags};
use rayon::prelude::*;

/// Half the side of the window of neighbours whose noise may be shared: JPEG's chroma of half size reaches three pixels.
const REACH: i64 = 4;
/// Most pixels that are looked at: more do not make a line's errors matter less.
const MOST: usize = 1 << 19;
/// Pixels of a level, at least, and levels, at most.
const FEWEST: usize = 1024;
const LEVELS: usize = 48;
/// Distance of the neighbour that two scenes are told apart by: beyond what noise shares.
const APART: usize = 8;

/// One channel of frames of one size.
pub(super) struct Frames<'a> {
    pub width: usize,
    /// A channel's values, frame by frame.
    pub frames: &'a [Vec<f32>],
    /// Pixels that are not clipped in any frame.
    pub usable: &'a [bool],
}

/// Side of the blocks whose means tell whether a difference is noise, pixels.
const WIDE: usize = 16;
/// Of noise, means of blocks have a 256th of its variance, or with what neighbours share up to a tenth; of a change of the
/// scene or its light, nearly all.
const SMOOTH: f64 = 0.2;

/// Whether frames show one scene: what differs between them is less than what differs between places of one of them, and
/// is not smooth.
pub(super) fn is_one_scene(a: &[f32], b: &[f32], width: usize, usable: &[bool]) -> bool {
    let (mut between, mut within, mut count) = (0.0, 0.0, 0.0);
    let (mut sum_a, mut sum_b) = (0.0, 0.0);
    for (k, _) in usable.iter().enumerate().filter(|&(_, &good)| good) {
        (sum_a, sum_b) = (sum_a + f64::from(a[k]), sum_b + f64::from(b[k]));
    }
    let gain = if sum_b > 0.0 { sum_a / sum_b } else { 1.0 };
    let difference = |k: usize| f64::from(a[k]) - gain * f64::from(b[k]);
    for k in 0..usable.len() {
        if !usable[k] || k % width + APART >= width || !usable[k + APART] {
            continue;
        }
        let (here, there) = (f64::from(a[k]), f64::from(a[k + APART]));
        between += difference(k) * difference(k);
        within += (here - there) * (here - there);
        count += 1.0;
    }
    let (mut means, mut squares, mut blocks) = (0.0, 0.0, 0.0);
    for (x, y) in corners(width, usable.len(), WIDE, [0, 0]) {
        let places = || (y..y + WIDE).flat_map(|row| (x..x + WIDE).map(move |column| row * width + column));
        if places().all(|k| usable[k]) {
            let pixels = (WIDE * WIDE) as f64;
            let mean = places().map(difference).sum::<f64>() / pixels;
            means += mean * mean;
            squares += places().map(|k| difference(k) * difference(k)).sum::<f64>() / pixels;
            blocks += 1.0;
        }
    }
    // Of an even scene `between` and `within` are both twice the noise.
    count > 0.0 && between < 1.5 * within && (blocks < 4.0 || means < SMOOTH * squares)
}

/// The upper left corners of whole blocks, where pixel (0, 0) lies at `origin` of a picture whose blocks begin at its corner.
fn corners(width: usize, pixels: usize, side: usize, origin: [usize; 2]) -> impl Iterator<Item = (usize, usize)> {
    let height = pixels / width.max(1);
    let starts = move |length: usize, origin: usize| {
        ((side - origin % side) % side..length.saturating_sub(side - 1)).step_by(side)
    };
    starts(height, origin[1]).flat_map(move |y| starts(width, origin[0]).map(move |x| (x, y)))
}

/// Levels of blocks have at least this many of them.
const FEWEST_BLOCKS: usize = 24;
/// A block is flat where it differs within itself by at most this much more than the flattest quarter does.
const ROUGHER: f64 = 6.0;

/// The noise of a channel by means of JPEG's whole blocks, which keep it.
pub(super) fn block_levels(channel: &Frames<'_>, side: usize, origin: [usize; 2]) -> Vec<Level> {
    let Frames { width, frames, usable } = *channel;
    let count = frames.len() as f64;
    let gain = gains(channel);
    let pixels = (side * side) as f64;
    let block = |(x, y): (usize, usize)| {
        let places = || (y..y + side).flat_map(|row| (x..x + side).map(move |column| row * width + column));
        if !places().all(|k| usable[k]) {
            return None;
        }
        let value = |frame: usize, k: usize| gain[frame] * f64::from(frames[frame][k]);
        let middle = |k: usize| (0..frames.len()).map(|frame| value(frame, k)).sum::<f64>() / count;
        let mean = places().map(middle).sum::<f64>() / pixels;
        let rough = places().map(|k| (middle(k) - mean).powi(2)).sum::<f64>() / pixels;
        let off = |frame: usize| places().map(|k| value(frame, k)).sum::<f64>() / pixels - mean;
        let shared = (0..frames.len()).map(|frame| off(frame).powi(2)).sum::<f64>() * pixels / (count - 1.0);
        let own = |k: usize| (0..frames.len()).map(|frame| (value(frame, k) - middle(k)).powi(2)).sum::<f64>();
        let variance = places().map(own).sum::<f64>() / (pixels * (count - 1.0));
        Some((rough, Level { mean, variance, shared, freedom: count - 1.0 }))
    };
    let all: Vec<(usize, usize)> = corners(width, usable.len(), side, origin).collect();
    let mut found: Vec<(f64, Level)> = all.into_par_iter().filter_map(block).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let limit = ROUGHER * found.get(found.len() / 4).map_or(0.0, |(rough, _)| *rough);
    let mut flat: Vec<Level> = found.into_iter().filter(|(rough, _)| *rough <= limit).map(|(_, level)| level).collect();
    flat.sort_by(|a, b| a.mean.total_cmp(&b.mean));
    let size = flat.len().div_ceil(LEVELS).max(FEWEST_BLOCKS);
    let together = |levels: &[Level]| {
        let n = levels.len() as f64;
        let mean = |of: fn(&Level) -> f64| levels.iter().map(of).sum::<f64>() / n;
        Level {
            mean: mean(|level| level.mean),
            variance: mean(|level| level.variance),
            shared: mean(|level| level.shared),
            freedom: n * (count - 1.0),
        }
    };
    flat.chunks(size).filter(|levels| levels.len() * 2 >= FEWEST_BLOCKS).map(together).collect()
}

/// What makes each frame as bright as their mean: a lamp that flickers changes whole frames, which is no noise of a pixel.
fn gains(channel: &Frames<'_>) -> Vec<f64> {
    let sum = |frame: &Vec<f32>| -> f64 {
        frame.iter().zip(channel.usable).filter(|(_, good)| **good).map(|(value, _)| f64::from(*value)).sum()
    };
    let sums: Vec<f64> = channel.frames.iter().map(sum).collect();
    let mean = sums.iter().sum::<f64>() / sums.len().max(1) as f64;
    sums.iter().map(|own| if *own > 0.0 && mean > 0.0 { mean / own } else { 1.0 }).collect()
}

/// The noise of a channel at up to 48 brightnesses.
pub(super) fn levels(channel: &Frames<'_>) -> Vec<Level> {
    let Frames { width, frames, usable } = *channel;
    let count = frames.len() as f64;
    let pixels = usable.len();
    let mut mean = vec![0.0_f64; pixels];
    for frame in frames {
        mean.iter_mut().zip(frame).for_each(|(mean, value)| *mean += f64::from(*value) / count);
    }
    let gain = gains(channel);
    let residual = |frame: usize, pixel: usize| gain[frame] * f64::from(frames[frame][pixel]) - mean[pixel];

    let slope = |k: usize| {
        let right = if k % width + 1 < width { mean[k + 1] } else { mean[k] };
        let below = mean.get(k + width).copied().unwrap_or(mean[k]);
        (right - mean[k]).abs() + (below - mean[k]).abs()
    };
    // At edges a camera that moved by a tenth of a pixel shows more than noise: the flatter half counts.
    let mut order: Vec<(f64, usize)> = (0..pixels).filter(|&k| usable[k]).map(|k| (slope(k), k)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.truncate(order.len().div_ceil(2));
    let mut chosen: Vec<usize> = order.into_iter().map(|(_, k)| k).collect();
    chosen.sort_unstable();
    let every = chosen.len().div_ceil(MOST).max(1);
    let mut chosen: Vec<usize> = chosen.into_iter().step_by(every).collect();
    chosen.sort_by(|&a, &b| mean[a].total_cmp(&mean[b]).then(a.cmp(&b)));

    let size = chosen.len().div_ceil(LEVELS).max(FEWEST);
    let lags = half_lags(REACH);
    chosen
        .par_chunks(size)
        .filter(|level| level.len() * 2 >= FEWEST)
        .map(|level| {
            let n = level.len() as f64;
            let freedom = n * (count - 1.0);
            let square = |k: usize| (0..frames.len()).map(|frame| residual(frame, k) * residual(frame, k)).sum::<f64>();
            let variance = level.iter().map(|&k| square(k)).sum::<f64>() / freedom;
            let mut shared = variance;
            for &[dx, dy] in &lags {
                let (mut sum, mut pairs) = (0.0, 0.0);
                for &k in level {
                    let x = (k % width) as i64 + dx;
                    let other = k as i64 + dx + dy * width as i64;
                    if x < 0 || x >= width as i64 || other < 0 || other >= pixels as i64 || !usable[other as usize] {
                        continue;
                    }
                    sum += (0..frames.len())
                        .map(|frame| residual(frame, k) * residual(frame, other as usize))
                        .sum::<f64>();
                    pairs += 1.0;
                }
                shared += if pairs > 0.0 { 2.0 * sum / (pairs * (count - 1.0)) } else { 0.0 };
            }
            let mean = level.iter().map(|&k| mean[k]).sum::<f64>() / n;
            Level { mean, variance, shared, freedom }
        })
        .collect()
}
