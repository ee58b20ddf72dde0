//! A texture at every size: what a wide ray sees is a mean.
//!
//! Each level has half the sides of the one before, its texels the means of what they cover (Williams 1983, "Pyramidal
//! parametrics"); between texels and between levels values are linear.

use glam::{Vec2, Vec3};
use gonio_scene::image::Image;
use gonio_scene::mesh::Wrap;

/// An image and its smaller versions.
pub struct MipMap {
    /// The image itself first, a single texel last.
    levels: Vec<Level>,
}

struct Level {
    width: usize,
    height: usize,
    texels: Vec<Vec3>,
}

impl MipMap {
    /// Builds the levels of an image, which has at least one pixel.
    #[must_use]
    pub fn new(image: &Image) -> Self {
        let texels = image.pixels.iter().map(|pixel| Vec3::from(*pixel)).collect();
        let mut levels = vec![Level { width: image.width as usize, height: image.height as usize, texels }];
        while let Some(smaller) = levels.last().and_then(Level::halved) {
            levels.push(smaller);
        }
        Self { levels }
    }

    /// The value at texture coordinates, for a ray that covers `area` of the unit square.
    #[must_use]
    pub fn at(&self, at: Vec2, wrap: [Wrap; 2], area: f32) -> Vec3 {
        // How many texels of a level the ray sees: it takes the level of which it sees one.
        let seen = |level: &Level| area * level.texels.len() as f32;
        let upper = self.levels.partition_point(|level| seen(level) > 1.0);
        let Some(fine) = upper.checked_sub(1).map(|below| &self.levels[below]) else {
            return self.levels[0].at(at, wrap);
        };
        let value = fine.at(at, wrap);
        let Some(coarse) = self.levels.get(upper) else { return value };
        // A level has a quarter of the texels of the one before; where a side is down to one texel, half of them.
        let share = libm::log2f(seen(fine)) / libm::log2f(seen(fine) / seen(coarse));
        value.lerp(coarse.at(at, wrap), share)
    }
}

impl Level {
    /// The next level; `None` behind a single texel.
    fn halved(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let half = |side: usize| (side / 2).max(1);
        let (width, height) = (half(self.width), half(self.height));
        let (columns, rows) = (shares(self.width, width), shares(self.height, height));
        let mut texels = Vec::with_capacity(width * height);
        for row in &rows {
            for column in &columns {
                let mut sum = Vec3::ZERO;
                for (y, down) in row {
                    for (x, right) in column {
                        sum += self.texels[y * self.width + x] * (down * right);
                    }
                }
                texels.push(sum);
            }
        }
        Some(Self { width, height, texels })
    }

    fn at(&self, at: Vec2, wrap: [Wrap; 2]) -> Vec3 {
        let (x, right) = place(at.x, self.width, wrap[0]);
        let (y, down) = place(at.y, self.height, wrap[1]);
        let texel = |y: usize, x: usize| self.texels[y * self.width + x];
        let top = texel(y[0], x[0]).lerp(texel(y[0], x[1]), right);
        top.lerp(texel(y[1], x[0]).lerp(texel(y[1], x[1]), right), down)
    }
}

/// For each of `few` texels, which of `many` it covers and which part of its mean they are.
fn shares(many: usize, few: usize) -> Vec<Vec<(usize, f32)>> {
    let size = many as f64 / few as f64;
    let of = |index: usize| {
        let (low, high) = (index as f64 * size, (index + 1) as f64 * size);
        let covered = low as usize..(high.ceil() as usize).min(many);
        let part = |k: usize| (high.min((k + 1) as f64) - low.max(k as f64)) / size;
        covered.map(|k| (k, part(k) as f32)).filter(|(_, part)| *part > 0.0).collect()
    };
    (0..few).map(of).collect()
}

/// The two texels around a coordinate, whose middles lie at half texels, and how far it is from the first to the second.
fn place(at: f32, size: usize, wrap: Wrap) -> ([usize; 2], f32) {
    let scaled = at * size as f32 - 0.5;
    let below = scaled.floor();
    let index = below as i64;
    let side = size as i64;
    let inside = |k: i64| match wrap {
        Wrap::Repeat => k.rem_euclid(side),
        Wrap::Clamp => k.clamp(0, side - 1),
        Wrap::Mirror => {
            let k = k.rem_euclid(2 * side);
            k.min(2 * side - 1 - k)
        }
    };
    ([inside(index) as usize, inside(index + 1) as usize], scaled - below)
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPEAT: [Wrap; 2] = [Wrap::Repeat; 2];

    fn ramp(width: u32, height: u32) -> MipMap {
        let value = |k: u32| [(k % width) as f32, (k / width) as f32, ((k * 7) % 5) as f32];
        MipMap::new(&Image { width, height, pixels: (0..width * height).map(value).collect() })
    }

    #[test]
    fn a_texel_s_middle_has_its_value_and_what_lies_between_is_linear() {
        let map = ramp(4, 3);
        let middle = |x: f32, y: f32| map.at(Vec2::new((x + 0.5) / 4.0, (y + 0.5) / 3.0), REPEAT, 0.0);
        assert!((middle(2.0, 1.0) - Vec3::new(2.0, 1.0, 2.0)).length() < 1e-5);
        assert!((middle(2.25, 1.5).truncate() - Vec2::new(2.25, 1.5)).length() < 1e-5);
    }

    #[test]
    fn sides_go_on_as_they_are_told() {
        let map = ramp(4, 1);
        let at = |x: f32, wrap: Wrap| map.at(Vec2::new((x + 0.5) / 4.0, 0.5), [wrap; 2], 0.0).x;
        for (x, repeat, mirror, clamp) in [(-1.0, 3.0, 0.0, 0.0), (4.0, 0.0, 3.0, 3.0), (5.0, 1.0, 2.0, 3.0)] {
            assert_eq!(at(x, Wrap::Repeat), repeat, "{x}");
            assert_eq!(at(x, Wrap::Mirror), mirror, "{x}");
            assert_eq!(at(x, Wrap::Clamp), clamp, "{x}");
        }
    }

    #[test]
    fn every_level_has_the_image_s_mean_whatever_its_size() {
        for (width, height) in [(8, 8), (7, 5), (1, 9), (13, 1), (1, 1)] {
            let map = ramp(width, height);
            let mean = |level: &Level| level.texels.iter().copied().sum::<Vec3>() / level.texels.len() as f32;
            let whole = mean(&map.levels[0]);
            assert!(map.levels.iter().all(|level| (mean(level) - whole).length() < 1e-5), "{width} x {height}");
            assert_eq!(map.levels.last().map(|level| level.texels.len()), Some(1));
            assert!((map.at(Vec2::new(0.3, 0.8), REPEAT, 1.0) - whole).length() < 1e-4);
        }
    }

    #[test]
    fn a_wide_ray_over_a_fine_checker_sees_its_mean() {
        let pixels = (0..64 * 64).map(|k| [if (k % 64 + k / 64) % 2 == 0 { 1.0 } else { 0.25 }; 3]).collect();
        let map = MipMap::new(&Image { width: 64, height: 64, pixels });
        for at in [Vec2::new(0.1, 0.2), Vec2::new(0.501, 0.77), Vec2::new(-3.2, 5.1)] {
            // Two texels wide: one level up.
            assert!((map.at(at, REPEAT, 4.0 / 4096.0).x - 0.625).abs() < 1e-5, "{at}");
        }
    }
}
