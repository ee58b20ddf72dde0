//! What a response curve is learnt from: smooth patches of a stack.

use super::region::Region;
use super::stack::Stack;

/// Patches that the curve is learnt from.
const SAMPLES: usize = 3000;

/// A patch's value by shot; none where it is saturated, dark, or outside of the frame.
pub(super) type Patch = Vec<Option<f32>>;

/// Smooth 3 x 3 patches of the region that are exposed in two or more shots, spread over the brightnesses. Their mean has
/// a third of a pixel's noise, which would bend the curve.
pub(super) fn patches(stack: &Stack, region: Region, channel: usize) -> Vec<Patch> {
    let (width, height) = stack.size();
    let [left, top, right, bottom] = region.bounds(width, height);
    let (left, top) = (left.max(1), top.max(1));
    let (right, bottom) = (right.min(width - 1), bottom.min(height - 1));
    let area = right.saturating_sub(left) * bottom.saturating_sub(top);
    // About twenty times as many as are kept: enough to be choosy.
    let step = (libm::sqrt(area as f64 / (20.0 * SAMPLES as f64)) as usize).max(1);
    let mut found: Vec<(f64, f64, Patch)> = Vec::new();
    for y in (top..bottom).step_by(step) {
        for x in (left..right).step_by(step) {
            let (mut roughness, mut brightness) = (0.0_f64, 0.0);
            let patch: Patch = (0..stack.shots().len())
                .map(|shot| {
                    let (mean, spread) = patch(stack, shot, channel, x, y)?;
                    brightness += mean;
                    if !(0.012..=0.98).contains(&mean) {
                        return None;
                    }
                    roughness = roughness.max(spread);
                    Some(mean as f32)
                })
                .collect();
            if patch.iter().flatten().count() >= 2 {
                found.push((roughness, brightness, patch));
            }
        }
    }
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    // Of every run of equally bright patches the smoothest are taken.
    let run = found.len().div_ceil(SAMPLES / 10).max(1);
    let mut kept = Vec::with_capacity(SAMPLES);
    for run in found.chunks_mut(run) {
        run.sort_by(|a, b| a.0.total_cmp(&b.0));
        kept.extend(run.iter().take(10).map(|(_, _, patch)| patch.clone()));
    }
    kept
}

/// Mean and range of the 3 x 3 pixels about (x, y); none where one of them is clipped or outside of the frame.
fn patch(stack: &Stack, shot: usize, channel: usize, x: usize, y: usize) -> Option<(f64, f64)> {
    let (width, _) = stack.size();
    let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for row in y - 1..=y + 1 {
        for column in x - 1..=x + 1 {
            let value = f64::from(stack.value(shot, row * width + column)?[channel]);
            sum += value;
            least = least.min(value);
            most = most.max(value);
        }
    }
    // A clipped pixel would pull its patch's mean.
    (least > 0.004 && most < 0.994).then_some((sum / 9.0, most - least))
}
