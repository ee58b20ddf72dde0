//! What a pixel's value is likely to be, by the pixels around it and not by itself.
//!
//! A weight that is made of a pixel's own value depends on that value's noise: bright accidents would weigh less than dark
//! ones and pull every estimate down. The mean over the neighbours is free of it.

use crate::image::Image;

/// Half the side of the window in pixels: 3x3 pixels, the smallest that has neighbours on every side.
const RADIUS: usize = 1;

/// The mean of the pixels around each pixel that `counts`, without itself, per channel; row-major, zero where a pixel does
/// not count. One without neighbours takes the mean of all others that count, the only one its own value.
pub(crate) fn surroundings(image: &Image, counts: &[bool]) -> Vec<[f32; 3]> {
    let (width, height) = (image.width as usize, image.height as usize);
    let mut total = Sum::default();
    for (pixel, _) in image.pixels.iter().zip(counts).filter(|(_, counts)| **counts) {
        total.add(pixel);
    }
    let mut around = vec![[0.0; 3]; image.pixels.len()];
    for y in 0..height {
        let rows = y.saturating_sub(RADIUS)..(y + RADIUS + 1).min(height);
        for x in (0..width).filter(|x| counts[y * width + x]) {
            let columns = x.saturating_sub(RADIUS)..(x + RADIUS + 1).min(width);
            let mut near = Sum::default();
            for row in rows.clone() {
                for place in columns.clone().map(|column| row * width + column) {
                    if counts[place] && place != y * width + x {
                        near.add(&image.pixels[place]);
                    }
                }
            }
            let own = &image.pixels[y * width + x];
            around[y * width + x] = near.mean().or_else(|| total.without(own).mean()).unwrap_or(*own);
        }
    }
    around
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
        let around = surroundings(&image, &[true; 9]);
        assert_eq!(around[4], [5.0; 3]);
        assert_eq!(around[0], [(2.0 + 4.0 + 100.0) / 3.0; 3]);
    }

    #[test]
    fn only_pixels_that_count_speak() {
        let image = image(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let around = surroundings(&image, &[true, false, true, false, false, true]);
        // The first has no neighbour that counts; the last two have each other.
        assert_eq!(around, [[4.5; 3], [0.0; 3], [6.0; 3], [0.0; 3], [0.0; 3], [3.0; 3]]);
        assert_eq!(surroundings(&image, &[false, true, false, false, false, false])[1], [2.0; 3]);
    }
}
