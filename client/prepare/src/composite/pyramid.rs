//! A part of a picture at ever lower resolution.

use gonio_scene::image::Image;

/// Levels: means over 1, 2, 4, ... 32 pixels.
pub(super) const LEVELS: usize = 6;

/// Halved pictures of a rectangle: width, height and pixels of levels 1 and up.
pub(super) struct Pyramid {
    levels: Vec<(usize, usize, Vec<[f32; 3]>)>,
}

impl Pyramid {
    /// Of the rectangle left, top, right, bottom of `image`, not empty.
    pub(super) fn new(image: &Image, [left, top, right, bottom]: [usize; 4]) -> Self {
        let stride = image.width as usize;
        let fine = &image.pixels[top * stride + left..];
        let mut levels: Vec<(usize, usize, Vec<[f32; 3]>)> = vec![halved(fine, stride, right - left, bottom - top)];
        while levels.len() + 1 < LEVELS
            && let Some((width, height, fine)) = levels.last()
        {
            let coarse = halved(fine, *width, *width, *height);
            levels.push(coarse);
        }
        Self { levels }
    }

    /// The rectangle's value at column x, row y, at a level between 0 and [`LEVELS`] - 1: linear in all three. `own` is the
    /// picture's value there: level 0, which is not copied.
    pub(super) fn at(&self, own: [f32; 3], x: usize, y: usize, level: f32) -> [f32; 3] {
        let lower = (level as usize).min(LEVELS - 2);
        let part = level - lower as f32;
        let a = if lower == 0 { own } else { self.bilinear(x, y, lower) };
        let b = self.bilinear(x, y, lower + 1);
        std::array::from_fn(|c| a[c] + part * (b[c] - a[c]))
    }

    fn bilinear(&self, x: usize, y: usize, level: usize) -> [f32; 3] {
        let (width, height, pixels) = &self.levels[level - 1];
        let size = 1.0 / (1_u32 << level) as f32;
        let column = ((x as f32 + 0.5) * size - 0.5).clamp(0.0, (width - 1) as f32);
        let row = ((y as f32 + 0.5) * size - 0.5).clamp(0.0, (height - 1) as f32);
        let (x, y) = (column as usize, row as usize);
        let (right, below) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
        let (fx, fy) = (column - x as f32, row - y as f32);
        let (a, b) = (pixels[y * width + x], pixels[y * width + right]);
        let (c, d) = (pixels[below * width + x], pixels[below * width + right]);
        std::array::from_fn(|k| {
            let (top, bottom) = (a[k] + fx * (b[k] - a[k]), c[k] + fx * (d[k] - c[k]));
            top + fy * (bottom - top)
        })
    }
}

/// Means of two by two of `fine`, rows of `width` values `stride` apart; an odd last one counts twice.
fn halved(fine: &[[f32; 3]], stride: usize, width: usize, height: usize) -> (usize, usize, Vec<[f32; 3]>) {
    let (across, down) = (width.div_ceil(2), height.div_ceil(2));
    let mut coarse = Vec::with_capacity(across * down);
    for y in 0..down {
        let upper = &fine[2 * y * stride..][..width];
        let lower = &fine[(2 * y + 1).min(height - 1) * stride..][..width];
        let mean = |a: &[[f32; 3]], b: &[[f32; 3]]| {
            let (a_last, b_last) = (a[a.len() - 1], b[b.len() - 1]);
            std::array::from_fn(|c| 0.25 * (a[0][c] + a_last[c] + b[0][c] + b_last[c]))
        };
        coarse.extend(upper.chunks(2).zip(lower.chunks(2)).map(|(a, b)| mean(a, b)));
    }
    (across, down, coarse)
}
