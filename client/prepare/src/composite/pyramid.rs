//! A part of a picture at ever lower resolution.

use gonio_scene::image::Image;

/// Levels: means over 1, 2, 4, ... 32 pixels.
pub(super) const LEVELS: usize = 6;

/// Halved pictures of a rectangle.
pub(super) struct Pyramid {
    levels: Vec<(usize, usize, Vec<[f32; 3]>)>,
}

impl Pyramid {
    /// Of the rectangle left, top, right, bottom of `image`, not empty.
    pub(super) fn new(image: &Image, [left, top, right, bottom]: [usize; 4]) -> Self {
        let width = image.width as usize;
        let rows = (top..bottom).flat_map(|y| &image.pixels[y * width + left..y * width + right]);
        let mut levels = vec![(right - left, bottom - top, rows.copied().collect::<Vec<_>>())];
        for level in 1..LEVELS {
            let (width, height, fine) = &levels[level - 1];
            let (across, down) = (width.div_ceil(2), height.div_ceil(2));
            let mut coarse = Vec::with_capacity(across * down);
            for y in 0..down {
                let upper = &fine[2 * y * width..][..*width];
                let lower = &fine[(2 * y + 1).min(height - 1) * width..][..*width];
                for x in 0..across {
                    let (at, next) = (2 * x, (2 * x + 1).min(width - 1));
                    let mean =
                        std::array::from_fn(|c| 0.25 * (upper[at][c] + upper[next][c] + lower[at][c] + lower[next][c]));
                    coarse.push(mean);
                }
            }
            levels.push((across, down, coarse));
        }
        Self { levels }
    }

    /// The rectangle's value at column x, row y, at a level between 0 and [`LEVELS`] - 1: linear in all three.
    pub(super) fn at(&self, x: usize, y: usize, level: f32) -> [f32; 3] {
        let lower = (level as usize).min(LEVELS - 2);
        let part = level - lower as f32;
        let (a, b) = (self.bilinear(x, y, lower), self.bilinear(x, y, lower + 1));
        std::array::from_fn(|c| a[c] + part * (b[c] - a[c]))
    }

    fn bilinear(&self, x: usize, y: usize, level: usize) -> [f32; 3] {
        let (width, height, pixels) = &self.levels[level];
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
