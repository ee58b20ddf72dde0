//! Hand-held stacks, by median threshold bitmaps: Ward, "Fast, robust image registration for compositing high dynamic range
//! photographs from hand-held exposures", Journal of Graphics Tools 8(2), 2003.

use super::stack::{Shot, Stack};

/// Levels of the pyramid: shifts up to 2^6 - 1 = 63 pixels.
const LEVELS: u32 = 6;
/// Codes 0..1 about the median that are noise, and count neither way.
const NOISE: f32 = 4.0 / 255.0;

/// A bitmap: brighter than the median; and where that is certain.
struct Bitmap {
    width: i64,
    height: i64,
    bright: Vec<bool>,
    certain: Vec<bool>,
}

/// Columns and rows by which every shot has to be moved to lie on the middle one. Each is held against its neighbour in
/// exposure, since far exposures share few medians.
pub fn shifts(stack: &Stack) -> Vec<[i32; 2]> {
    let grays: Vec<Gray> = stack.shots().iter().map(Gray::new).collect();
    let middle = grays.len() / 2;
    let mut shifts = vec![[0, 0]; grays.len()];
    for k in (0..middle).rev() {
        shifts[k] = add(shifts[k + 1], shift(&grays[k], &grays[k + 1], LEVELS));
    }
    for k in middle + 1..grays.len() {
        shifts[k] = add(shifts[k - 1], shift(&grays[k], &grays[k - 1], LEVELS));
    }
    shifts
}

fn add(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// Ward's gray: (54 R + 183 G + 19 B) / 256.
#[derive(Clone)]
struct Gray {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Gray {
    fn new(shot: &Shot) -> Self {
        let gray = |pixel: &[f32; 3]| (54.0 * pixel[0] + 183.0 * pixel[1] + 19.0 * pixel[2]) / 256.0;
        let image = &shot.image;
        Self {
            width: image.width as usize,
            height: image.height as usize,
            values: image.pixels.iter().map(gray).collect(),
        }
    }

    fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let mut values = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let at = 2 * y * self.width + 2 * x;
                let below = at + self.width;
                let sum = self.values[at] + self.values[at + 1] + self.values[below] + self.values[below + 1];
                values.push(0.25 * sum);
            }
        }
        Self { width, height, values }
    }

    fn bitmap(&self) -> Bitmap {
        let mut sorted = self.values.clone();
        let middle = sorted.len() / 2;
        let median = *sorted.select_nth_unstable_by(middle, f32::total_cmp).1;
        Bitmap {
            width: self.width as i64,
            height: self.height as i64,
            bright: self.values.iter().map(|&value| value > median).collect(),
            certain: self.values.iter().map(|&value| (value - median).abs() > NOISE).collect(),
        }
    }
}

/// The shift that lays `moved` on `fixed`, from coarse to fine: twice the coarser one's, and one pixel about it.
fn shift(moved: &Gray, fixed: &Gray, levels: u32) -> [i32; 2] {
    let coarse = if levels > 1 && moved.width >= 16 && moved.height >= 16 {
        shift(&moved.halved(), &fixed.halved(), levels - 1).map(|part| 2 * part)
    } else {
        [0, 0]
    };
    let (moved, fixed) = (moved.bitmap(), fixed.bitmap());
    let mut best = (f64::INFINITY, coarse);
    // The unmoved one first: it wins where all are alike.
    for (dx, dy) in [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
        let tried = [coarse[0] + dx, coarse[1] + dy];
        let error = difference(&moved, &fixed, tried);
        if error < best.0 {
            best = (error, tried);
        }
    }
    best.1
}

/// Part of the overlap that is certain in both and differs.
fn difference(moved: &Bitmap, fixed: &Bitmap, shift: [i32; 2]) -> f64 {
    let [dx, dy] = shift.map(i64::from);
    let (mut differ, mut all) = (0_usize, 0_usize);
    for y in dy.max(0)..(moved.height + dy).min(moved.height) {
        for x in dx.max(0)..(moved.width + dx).min(moved.width) {
            let a = (y * fixed.width + x) as usize;
            let b = ((y - dy) * moved.width + x - dx) as usize;
            all += 1;
            if fixed.certain[a] && moved.certain[b] {
                differ += usize::from(fixed.bright[a] != moved.bright[b]);
            }
        }
    }
    if all == 0 { f64::INFINITY } else { differ as f64 / all as f64 }
}
