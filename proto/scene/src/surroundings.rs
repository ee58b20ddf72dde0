//! What a pixel's value is likely to be, by the pixels around it and not by itself.
//!
//! A weight that is made of a pixel's own value depends on that value's noise: bright accidents would weigh less than dark
//! ones and pull every estimate down. The mean over the neighbours is free of it.

use crate::image::Image;

/// Half the side of the window in pixels: 3x3 pixels, the smallest that has neighbours on every side.
const RADIUS: usize = 1;

/// The means of the pixels around those of an image.
#[derive(Debug)]
pub struct Surroundings<'a> {
    image: &'a Image,
    counts: &'a [bool],
    /// Over all pixels that count.
    total: Sum,
}

impl<'a> Surroundings<'a> {
    /// Of an image, by its pixels that `counts`: as many as it has, row-major.
    #[must_use]
    pub fn new(image: &'a Image, counts: &'a [bool]) -> Self {
        let mut total = Sum::default();
        for (pixel, _) in image.pixels.iter().zip(counts).filter(|(_, counts)| **counts) {
            total.add(pixel);
        }
        Self { image, counts, total }
    }

    /// The mean of the pixels around column `x` and row `y` that count, without that pixel, per channel. Without neighbours it takes
    /// the mean of all others that count, and where there is no other, its own value.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> [f32; 3] {
        let (width, height) = (self.image.width as usize, self.image.height as usize);
        let columns = x.saturating_sub(RADIUS)..(x + RADIUS + 1).min(width);
        let mut near = Sum::default();
        for row in y.saturating_sub(RADIUS)..(y + RADIUS + 1).min(height) {
            for place in columns.clone().map(|column| row * width + column) {
                if self.counts[place] && place != y * width + x {
                    near.add(&self.image.pixels[place]);
                }
            }
        }
        let own = &self.image.pixels[y * width + x];
        near.mean().or_else(|| self.total.without(own).mean()).unwrap_or(*own)
    }

    /// Of every pixel, row-major; zero where one does not count.
    #[must_use]
    pub fn all(&self) -> Vec<[f32; 3]> {
        let width = (self.image.width as usize).max(1);
        let at =
            |(place, counts): (usize, &bool)| if *counts { self.at(place % width, place / width) } else { [0.0; 3] };
        self.counts.iter().enumerate().map(at).collect()
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    values: [f64; 3],
    pixels: f64,
}

impl Sum {
    fn add(&mut self, pixel: &[f32; 3]) {
        self.values.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += f64::from(*value));
        self.pixels += 1.0;
    }

    fn without(mut self, pixel: &[f32; 3]) -> Self {
        self.values.iter_mut().zip(pixel).for_each(|(sum, value)| *sum -= f64::from(*value));
        self.pixels -= 1.0;
        self
    }

    fn mean(&self) -> Option<[f32; 3]> {
        #[allow(clippy::cast_possible_truncation)]
        let mean = self.values.map(|sum| (sum / self.pixels) as f32);
        (self.pixels >= 1.0).then_some(mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(values: &[f32]) -> Image {
        Image { width: 3, height: values.len() as u32 / 3, pixels: values.iter().map(|v| [*v; 3]).collect() }
    }

    #[test]
    fn a_pixel_is_no_part_of_its_surroundings() {
        let image = image(&[1.0, 2.0, 3.0, 4.0, 100.0, 6.0, 7.0, 8.0, 9.0]);
        let around = Surroundings::new(&image, &[true; 9]).all();
        assert_eq!(around[4], [5.0; 3]);
        assert_eq!(around[0], [(2.0 + 4.0 + 100.0) / 3.0; 3]);
    }

    #[test]
    fn only_pixels_that_count_speak() {
        let image = image(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let around = Surroundings::new(&image, &[true, false, true, false, false, true]).all();
        // The first has no neighbour that counts; the last two have each other.
        assert_eq!(around, [[4.5; 3], [0.0; 3], [6.0; 3], [0.0; 3], [0.0; 3], [3.0; 3]]);
        assert_eq!(Surroundings::new(&image, &[false, true, false, false, false, false]).all()[1], [2.0; 3]);
    }
}
